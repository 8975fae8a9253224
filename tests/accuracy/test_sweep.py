"""Sweeps that are stopped and go on, in this process, in others and on a Dask cluster."""

from __future__ import annotations

import json
import os
import subprocess
import sys
import time
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from tests.accuracy.inline import Inline
from tests.accuracy.short_runs import jobs
from warp_softbody.accuracy.cases.settings import Settings
from warp_softbody.accuracy.runs.journal import RunJournal
from warp_softbody.accuracy.runs.outcome import RunOutcome
from warp_softbody.accuracy.runs.running import run_job
from warp_softbody.accuracy.runs.sweep import sweep
from warp_softbody.accuracy.runs.workers import workers
from warp_softbody.errors import InputError
from warp_softbody.run.simulation import Simulation

ROOT = Path(__file__).parents[2]


def assert_same(one: dict[str, RunOutcome], other: dict[str, RunOutcome]) -> None:
    """Everything but the times that were measured, to the last bit."""
    assert list(one) == list(other)
    apart = {"cost": 0.0, "setup": 0.0, "path": None}
    for key, outcome in one.items():
        np.testing.assert_array_equal(outcome.path, other[key].path)
        assert {**vars(outcome), **apart} == {**vars(other[key]), **apart}


@pytest.fixture(scope="module")
def straight(tmp_path_factory: pytest.TempPathFactory) -> dict[str, RunOutcome]:
    """All of them, here, without a stop."""
    journal = RunJournal(tmp_path_factory.mktemp("straight"), "cantilever")
    return sweep(jobs(), journal, Inline())


def test_runs_are_measured(straight: dict[str, RunOutcome]) -> None:
    for job in jobs():
        outcome = straight[job.key]
        cells = job.settings.cells
        assert cells is not None
        assert (outcome.status, outcome.tets) == ("complete", 30 * cells**3)
        assert outcome.cost > 0.0 and outcome.memory > 0.0 and outcome.iterations > 0.0
        # the end of a hinged rod falls at most with 1.5 g, here in implicit Euler steps
        hinged = 0.75 * 9.81 * 0.2 * (0.2 + job.settings.time_step)
        assert 0.02 < outcome.functionals["tip_fall"] < hinged
        assert outcome.path.shape == (7, 128, 3)


def test_a_stopped_sweep_goes_on_where_it_was(
    straight: dict[str, RunOutcome], tmp_path: Path
) -> None:
    """After Ctrl-C when two runs are kept, and a line that was torn in the middle."""

    def interrupt(done: int, total: int) -> None:
        if done == 2:
            raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        sweep(jobs(), RunJournal(tmp_path, "cantilever"), Inline(), interrupt)
    file = tmp_path / "cantilever.jsonl"
    kept = file.read_text().splitlines()
    assert len(kept) == 2
    file.write_text("\n".join(kept) + "\n" + kept[-1][:40])
    again = Inline()
    told: list[tuple[int, int]] = []
    found = sweep(
        jobs(), RunJournal(tmp_path, "cantilever"), again, lambda a, b: told.append((a, b))
    )
    assert again.calls == len(jobs()) - len(kept)
    assert told[0] == (len(kept), 6) and told[-1] == (6, 6)
    assert_same(found, straight)
    # the third time nothing is left to do
    idle = Inline()
    assert_same(sweep(jobs(), RunJournal(tmp_path, "cantilever"), idle), straight)
    assert idle.calls == 0


def test_a_killed_sweep_goes_on_where_it_was(
    straight: dict[str, RunOutcome], tmp_path: Path
) -> None:
    script = f"""
import sys
from pathlib import Path
from tests.accuracy.short_runs import jobs
from warp_softbody.accuracy.runs.journal import RunJournal
from warp_softbody.accuracy.runs.sweep import sweep
from warp_softbody.accuracy.runs.workers import workers
if __name__ == "__main__":
    with workers(1) as executor:
        sweep(jobs(), RunJournal(Path({str(tmp_path)!r}), "cantilever"), executor)
"""
    source = tmp_path / "sweep_and_be_killed.py"
    source.write_text(script)
    file = tmp_path / "cantilever.jsonl"
    found = {**os.environ, "PYTHONPATH": str(ROOT)}
    process = subprocess.Popen([sys.executable, str(source)], cwd=ROOT, env=found)
    try:
        deadline = time.monotonic() + 60.0
        while not (file.exists() and file.read_text().count("\n") >= 2):
            assert time.monotonic() < deadline and process.poll() is None
            time.sleep(0.005)
    finally:
        process.kill()
        process.wait()
    kept = len(RunJournal(tmp_path, "cantilever").outcomes)
    assert kept >= 2
    rest = Inline()
    assert_same(sweep(jobs(), RunJournal(tmp_path, "cantilever"), rest), straight)
    assert rest.calls == len(jobs()) - kept


def test_other_processes_find_the_same(straight: dict[str, RunOutcome], tmp_path: Path) -> None:
    with workers(2) as executor:
        assert_same(sweep(jobs(), RunJournal(tmp_path, "cantilever"), executor), straight)


def test_a_dask_cluster_finds_the_same(straight: dict[str, RunOutcome], tmp_path: Path) -> None:
    distributed = pytest.importorskip("distributed")
    with (
        distributed.LocalCluster(
            n_workers=1, threads_per_worker=1, processes=True, dashboard_address=None
        ) as cluster,
        workers(1, cluster.scheduler_address) as executor,
    ):
        found = sweep(jobs(), RunJournal(tmp_path, "cantilever"), executor)
    assert_same(found, straight)


def test_a_dask_cluster_has_to_answer_and_to_have_one_thread_a_worker() -> None:
    distributed = pytest.importorskip("distributed")
    with (
        distributed.LocalCluster(
            n_workers=1, threads_per_worker=2, processes=False, dashboard_address=None
        ) as cluster,
        pytest.raises(InputError, match="has 2 threads; start workers with --nthreads 1"),
        workers(1, cluster.scheduler_address),
    ):
        pass


def test_keys_tell_runs_apart_and_not_processes(tmp_path: Path) -> None:
    keys = {job.key for job in jobs()}
    assert len(keys) == len(jobs()) and keys == {job.key for job in jobs()}
    first = jobs()[0]
    others = [
        replace(first, seconds=0.3),
        replace(first, given={"young_modulus": 2e6}),
        replace(first, solver="Pardiso"),
        replace(first, settings=replace(first.settings, tolerance=1e-3)),
    ]
    assert len({first.key, *(job.key for job in others)}) == 5
    assert json.loads(json.dumps(first.to_dict()))["settings"]["cells"] == 1


def test_a_combination_that_is_refused_does_not_end_a_sweep(tmp_path: Path) -> None:
    settings = Settings(time_step=1.0 / 60.0, elements="smoothed", tangent="exact")
    wrong = replace(jobs()[0], settings=settings)
    assert not settings.possible
    outcome = sweep([wrong], RunJournal(tmp_path, "cantilever"), Inline())[wrong.key]
    assert not outcome.complete and "no exact tangent" in outcome.status
    kept = RunJournal(tmp_path, "cantilever").outcomes[wrong.key]
    assert kept.status == outcome.status


def test_a_run_that_breaks_down_is_an_outcome(monkeypatch: pytest.MonkeyPatch) -> None:
    """Also where it is a plan that refuses numbers that are not finite; the frames before stay."""
    step = Simulation.step

    def breaks(simulation: Simulation) -> None:
        if simulation.time > 0.09:
            raise InputError("ContactQPCC.hessian must be finite")
        step(simulation)

    monkeypatch.setattr(Simulation, "step", breaks)
    outcome = run_job(jobs()[0])
    assert outcome.status == "ContactQPCC.hessian must be finite" and not outcome.complete
    # at 1/30 s: t = 0, 1/30, 2/30 and 3/30
    assert (outcome.tets, len(outcome.path), outcome.functionals) == (30, 4, {})


def test_gains_are_part_of_a_runs_key(monkeypatch: pytest.MonkeyPatch) -> None:
    """They change what a scene is, without a change of any setting."""
    from warp_softbody.accuracy.runs.job import fingerprint
    from warp_softbody.scenes import balance_i

    before = fingerprint("balance-i", (), None)
    fingerprint.cache_clear()
    assert fingerprint("balance-i", (), None) == before
    fingerprint.cache_clear()
    monkeypatch.setattr(balance_i, "GAINS", replace(balance_i.GAINS, crouch=1.2))
    assert fingerprint("balance-i", (), None) != before
    fingerprint.cache_clear()
