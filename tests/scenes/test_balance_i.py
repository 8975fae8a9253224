"""balance-i, measured from its stage: it stands, and recovers from a push that topples it limp."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from tests.scenes.runs import missed, run
from warp_softbody.cli.run_command import DOUBTFUL


def test_it_stands_for_six_seconds(tmp_path: Path) -> None:
    measures = run("balance-i", tmp_path, "--seconds", "6", "--set", "push=0").measures
    assert measures.tilt.max() < 10.0
    moved = measures.centre_of_mass[-1] - measures.centre_of_mass[0]
    assert np.linalg.norm(moved) < 0.02


@pytest.mark.parametrize("push", [0.45, 0.5])
def test_it_recovers_from_a_push(push: float, tmp_path: Path) -> None:
    """The base widens meanwhile, and part of it leaves the ground."""
    motion = run("balance-i", tmp_path, "--seconds", "6", "--set", f"push={push}")
    assert motion.measures.tilt.max() > 10.0
    assert missed("balance-i", motion) == []


@pytest.mark.parametrize("variant", [["--time-step", str(1 / 30)], ["--newton-iterations", "2"]])
def test_it_recovers_whatever_the_step_and_the_iterations(
    variant: list[str], tmp_path: Path
) -> None:
    """From the push of the scene, 0.5 body weights."""
    assert missed("balance-i", run("balance-i", tmp_path, *variant)) == []


def test_a_lighter_push_moves_it_little(tmp_path: Path) -> None:
    """The head is held over the base, so that the letter tips less than 10 degrees."""
    motion = run("balance-i", tmp_path, "--seconds", "6", "--set", "push=0.3")
    assert motion.measures.tilt.max() < 10.0
    path = motion.measures.centre_of_mass
    assert np.linalg.norm(path[-1] - path[0]) < 0.05


@pytest.mark.parametrize("push", [0.45, 0.5])
def test_a_plan_with_contacts_that_hold_still_falls(push: float, tmp_path: Path) -> None:
    """Under the push of the scene too, after which the QPCC stands."""
    asked = ["--set", f"push={push}"]
    assert missed("balance-i", run("balance-i", tmp_path, *asked)) == []
    static = run("balance-i", tmp_path, *asked, "--controller", "static", code=DOUBTFUL)
    measures = static.measures
    # a body 1 m high
    assert measures.centre_of_mass[-1, 2] < 0.5
    assert measures.tilt[-1] > 45.0


def test_without_muscles_the_push_topples_it(tmp_path: Path) -> None:
    options = ["--seconds", "3", "--set", "push=0.5", "--controller", "none"]
    measures = run("balance-i", tmp_path, *options).measures
    assert measures.centre_of_mass[-1, 2] < 0.5 * measures.centre_of_mass[0, 2] + 0.1
    assert measures.tilt[-1] > 45.0
