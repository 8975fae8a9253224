"""balance-i, measured from its stage: it stands, and recovers from a push that topples it limp."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from benchmarks.motions import measures as of
from benchmarks.robustness.turned_world import turned_pushes
from tests.scenes.runs import missed, run
from warp_softbody import Scene, Simulation, scenes
from warp_softbody.arrays import FloatArray
from warp_softbody.cli.run_command import DOUBTFUL
from warp_softbody.controllers import Controller
from warp_softbody.world.refined_scene import refined_scene


def test_it_stands_for_six_seconds(tmp_path: Path) -> None:
    measures = run("balance-i", tmp_path, "--seconds", "6", "--set", "push=0").measures
    assert measures.tilt.max() < 10.0
    moved = measures.centre_of_mass[-1] - measures.centre_of_mass[0]
    assert np.linalg.norm(moved) < 0.02


@pytest.mark.parametrize("push", [0.475, 0.5, 0.52])
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


@pytest.mark.parametrize("push", [0.65, -0.65])
def test_it_hops_after_a_push_that_it_cannot_bear_on_its_base(push: float, tmp_path: Path) -> None:
    """It is off the ground meanwhile, and stands on another place."""
    motion = run("balance-i", tmp_path, "--seconds", "6", "--set", f"push={push}")
    assert missed("balance-i", motion) == []
    assert max(of.flights(motion.take)) > 0.1
    path = motion.measures.centre_of_mass
    assert (path[-1, 0] - path[0, 0]) * np.sign(push) > 0.5
    assert abs(path[-1, 1] - path[0, 1]) < 0.05


@pytest.mark.parametrize(
    "variant",
    [
        ["--time-step", str(1 / 30)],
        ["--time-step", str(1 / 120)],
        ["--newton-iterations", "2"],
        pytest.param(["--time-step", str(1 / 240)], marks=pytest.mark.long),
    ],
)
def test_it_hops_whatever_the_step_and_the_iterations(variant: list[str], tmp_path: Path) -> None:
    options = ["--seconds", "6", "--set", "push=0.65", *variant]
    assert missed("balance-i", run("balance-i", tmp_path, *options)) == []


def stands_again(scene: Scene, controller: Controller, side: FloatArray) -> None:
    """At rest 3.3 s after the push, upright, and gone towards a side (2,)."""
    for frame in Simulation(scene, controller, time_step=1.0 / 60.0).run(4.0):
        last = frame
    rest, now = scene.character.mesh.points, np.asarray(last.positions)
    assert now[:, 2].max() > 0.95 * rest[:, 2].max()
    assert np.abs(last.velocities).max() < 0.1
    assert (now - rest).mean(axis=0)[:2] @ side > 0.1


@pytest.mark.parametrize("degrees", [45.0, 90.0])
def test_it_hops_towards_every_side(degrees: float) -> None:
    """On its base it falls at 0.45 towards a corner, and at 0.40 towards the narrow side."""
    plan = scenes.make("balance-i", {"push": 0.45})
    assert plan.controller is not None
    angle = np.radians(degrees)
    side = np.array([np.cos(angle), np.sin(angle)])
    stands_again(turned_pushes(plan.scene, degrees), plan.controller, side)


@pytest.mark.long
def test_it_hops_on_the_refined_mesh() -> None:
    plan = scenes.make("balance-i", {"push": 0.65})
    assert plan.controller is not None
    stands_again(refined_scene(plan.scene, 1), plan.controller, np.array([1.0, 0.0]))


def test_a_body_that_may_not_leave_its_base_falls(tmp_path: Path) -> None:
    asked = ["--set", "push=0.65", "--set", "hops=0", "--seconds", "3"]
    measures = run("balance-i", tmp_path, *asked, code=DOUBTFUL).measures
    assert measures.tilt[-1] > 45.0


def test_a_lighter_push_moves_it_little(tmp_path: Path) -> None:
    """The head is held over the base, so that the letter tips less than 5 degrees."""
    motion = run("balance-i", tmp_path, "--seconds", "6", "--set", "push=0.3")
    assert motion.measures.tilt.max() < 5.0
    path = motion.measures.centre_of_mass
    assert np.linalg.norm(path[-1] - path[0]) < 0.05


@pytest.mark.parametrize("push", [0.45, 0.5])
def test_a_plan_with_contacts_that_hold_still_falls(push: float, tmp_path: Path) -> None:
    """Under the push of the scene too, after which the QPCC stands; both on their base."""
    asked = ["--set", f"push={push}"]
    assert missed("balance-i", run("balance-i", tmp_path, *asked)) == []
    stays = [*asked, "--set", "hops=0", "--controller", "static"]
    static = run("balance-i", tmp_path, *stays, code=DOUBTFUL)
    measures = static.measures
    # a body 1 m high
    assert measures.centre_of_mass[-1, 2] < 0.5
    assert measures.tilt[-1] > 45.0


def test_without_muscles_the_push_topples_it(tmp_path: Path) -> None:
    options = ["--seconds", "3", "--set", "push=0.5", "--controller", "none"]
    measures = run("balance-i", tmp_path, *options).measures
    assert measures.centre_of_mass[-1, 2] < 0.5 * measures.centre_of_mass[0, 2] + 0.1
    assert measures.tilt[-1] > 45.0
