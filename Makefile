# Needs only Python (with venv), make and a package index.
#   make demo       installs into .venv and runs the main job: a letter that keeps its balance
#   make test       lints, type-checks and runs every test but the long ones, on all cores;
#                   prints which lines of Python they reach
#   make test-long  the long ones
#   make test-viewers  the pages in a browser of this machine, where there is one; installs Blender,
#                   Newton and NVIDIA's asset validator into out/viewers (2 GB) and lets them read
#                   stages; Blender's pictures are in out/viewers/pictures
#   make docs       builds the pages and the API reference as a site in out/site
#   make charts     charts error over cost of the scenes into docs/frontier (an hour on two cores),
#                   stores the settings that `run --error` uses, and brings the tables of
#                   docs/frontier.md up to date; stopped, it goes on where it was
#   make charts WORKERS=1   one run at a time, on a core that shares nothing with another run
#   make clean      removes what the others made
# Another interpreter: make PYTHON=python3.12 demo

PYTHON ?= python3
VENV := .venv
BIN := $(VENV)/bin
OUT := out
# Errors for which settings are stored; the least are what the references allow.
TUNED := cantilever=2% cantilever=5% twisted-bar=2% twisted-bar=5% drop-block=5% drop-block=10% \
	slope=1% stack=1% bounce-ball=20% bounce-ball=30% \
	exercise-h=10% balance-i=20% slide-f=10% slide-f-left=10% jump-i=10% \
	jump-i-in-place=10% jump-t=10% roll-o=10% roll-o-return=10% crawl-i=10% walk-x=10% walk-x-fast=10% \
	crawl-i-inchworm=20%

# Small dense matrices are solved faster, and runs repeat bit for bit, on one BLAS thread.
export OPENBLAS_NUM_THREADS := 1

# Programs that read stages, and the packages that each needs.
VIEWERS := validator blender newton
VIEWER_PYTHON ?= python3.11
PACKAGES_validator := omniverse-asset-validator==1.18.* usd-core==26.5 numpy
PACKAGES_blender := bpy==4.5.*
PACKAGES_newton := newton==1.8.* newton-usd-schemas usd-core

# Tests share the cores; a core that is done takes over from the others. One process: make JOBS=0 test
JOBS ?= auto
PARALLEL := -n $(JOBS) --maxprocesses 8 --dist worksteal
# Coverage takes a third more CPU time by tracing, and hardly any by the monitoring of Python 3.12.
TRACER := import sys; print('sysmon' if sys.version_info >= (3, 12) else 'ctrace')

.PHONY: demo test test-long test-viewers docs charts clean

demo: $(VENV)/.demo
	mkdir -p $(OUT)
	$(BIN)/warp-softbody run balance-i --seconds 6 \
		--out $(OUT)/balance-i.usdc --picture $(OUT)/balance-i.png
	@echo
	@echo "The stage   $(CURDIR)/$(OUT)/balance-i.usdc"
	@echo "The picture $(CURDIR)/$(OUT)/balance-i.png"

test: $(VENV)/.dev
	$(BIN)/ruff check .
	$(BIN)/ruff format --check .
	$(BIN)/mypy
	COVERAGE_CORE=$$($(BIN)/python -c "$(TRACER)") \
		$(BIN)/python -m pytest -q -m "not long and not viewers" $(PARALLEL) --durations=15 --cov --cov-report=term

test-long: $(VENV)/.dev
	$(BIN)/python -m pytest -q -m long

test-viewers: $(VENV)/.dev $(VIEWERS:%=$(OUT)/viewers/%/.installed)
	$(BIN)/python -m pytest -q -m viewers

docs: $(VENV)/.docs
	NO_MKDOCS_2_WARNING=1 $(BIN)/python -m mkdocs build --strict --quiet
	@echo "The site    $(CURDIR)/$(OUT)/site/index.html"

# A scene that fails is passed over; the rest is made and told before make fails.
charts: $(VENV)/.charts
	failed=0; \
	$(BIN)/python -m warp_softbody chart all --peers $(if $(WORKERS),--workers $(WORKERS)) \
		--out docs/frontier --journal $(OUT)/frontier || failed=1; \
	for pair in $(TUNED); do \
		$(BIN)/python -m warp_softbody tune $${pair%=*} --error $${pair#*=} --workers 1 \
			--journal $(OUT)/frontier --out warp_softbody/accuracy/analysis/tuned.json || failed=1; \
	done; \
	$(BIN)/python -m benchmarks.charts --write docs/frontier.md && exit $$failed

$(BIN)/python:
	$(PYTHON) -m venv $(VENV)

# An editable install only has to be made again when the dependencies change.
$(VENV)/.demo: pyproject.toml | $(BIN)/python
	$(BIN)/python -m pip install --quiet --disable-pip-version-check -e ".[view]"
	touch $@

$(VENV)/.charts: pyproject.toml | $(BIN)/python
	$(BIN)/python -m pip install --quiet --disable-pip-version-check -e ".[charts,bench]"
	touch $@

$(VENV)/.docs: pyproject.toml | $(BIN)/python
	$(BIN)/python -m pip install --quiet --disable-pip-version-check -e ".[docs]"
	touch $@

$(VENV)/.dev: pyproject.toml | $(BIN)/python
	$(BIN)/python -m pip install --quiet --disable-pip-version-check -e ".[dev]"
	touch $@

# Each program has an environment of its own; bpy 4.5 has wheels for Python 3.11 alone.
$(OUT)/viewers/%/.installed:
	$(VIEWER_PYTHON) -m venv $(OUT)/viewers/$*
	$(OUT)/viewers/$*/bin/python -m pip install --quiet --disable-pip-version-check $(PACKAGES_$*)
	touch $@

clean:
	rm -rf $(VENV) $(OUT) build dist *.egg-info .mypy_cache .ruff_cache .pytest_cache \
		.coverage .hypothesis
	find . -name __pycache__ -type d -prune -exec rm -rf {} +
