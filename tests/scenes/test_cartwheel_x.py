"""cartwheel-x, measured from its stage."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from benchmarks.motions.measures import turned
from benchmarks.perturbed_starts import PUSH, PerturbedStart, outcome
from tests.scenes.runs import Shipped, missed, run
from warp_softbody import scenes

SCENE = "cartwheel-x"
PERIMETER = 4.0 * (0.6 + 0.2 * np.sqrt(2.0))
"""m, of the hull of the letter: what it rolls off in a turn."""


def test_it_turns_once_over_all_limbs_and_stands(shipped: Shipped) -> None:
    motion = shipped(SCENE)
    assert missed(SCENE, motion) == []
    assert turned(motion.take, 1)[-1] == pytest.approx(360.0, abs=2.0)
    way = np.ptp(motion.measures.centre_of_mass[:, 0])
    assert way == pytest.approx(PERIMETER, abs=0.05)
    # never on its side, where it is 1 m wide, and never up in the air like a jumper
    assert np.abs(motion.take.tet_points[:, :, 1]).max() < 0.25
    assert motion.measures.centre_of_mass[:, 2].max() < 0.6


@pytest.mark.parametrize(
    "options",
    [("--time-step", "0.0083334"), ("--newton-iterations", "2"), ("--elements", "linear")],
    ids=["half the step", "two iterations", "linear elements"],
)
def test_it_does_so_however_it_is_computed(options: tuple[str, str], tmp_path: Path) -> None:
    assert missed(SCENE, run(SCENE, tmp_path, *options)) == []


def test_it_survives_a_perturbed_start(tmp_path: Path) -> None:
    """One from which it fell aside with the gains of a guess."""
    start = PerturbedStart.of(1, scenes.recipe(SCENE).seconds, PUSH)
    assert outcome(SCENE, start.plan(SCENE, {}, 0), tmp_path / "motion.usdc").failures == []


def test_limp_it_stays_where_it_stands(tmp_path: Path) -> None:
    motion = run(SCENE, tmp_path, "--controller", "none", "--seconds", "3")
    assert np.abs(turned(motion.take, 1)).max() < 5.0
