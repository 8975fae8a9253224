"""Sequences of motions on shipped characters: from their files to stages, and what these show."""

from __future__ import annotations

import math
import warnings
from pathlib import Path

import numpy as np
import pytest

from tests.support.surfaces import BODIES
from warp_softbody import Character, Plane, Scene, Simulation, scene_files, scenes
from warp_softbody.arrays import FloatArray
from warp_softbody.cli import main
from warp_softbody.controllers import (
    Balance,
    BalanceGains,
    Combined,
    Gesture,
    Jump,
    Leg,
    Motion,
    Roll,
    Sequence,
    Walk,
)
from warp_softbody.controllers.controller import Controller
from warp_softbody.errors import MeshWarning
from warp_softbody.run.falls import tilt
from warp_softbody.scenes import roll_o
from warp_softbody.scenes.plan import ScenePlan
from warp_softbody.stage_exports import StageWriter, read_take

LETTER_H = scenes.make("exercise-h").scene.character


def stage_of(folder: Path, character: Character, controller: Controller, seconds: float) -> Path:
    """The stage of a run on a plane."""
    scene = Scene(character=character, ground=Plane())
    simulation = Simulation(scene, controller, time_step=1 / 60)
    path = folder / "take.usdc"
    with StageWriter(path, scene) as writer:
        for frame in simulation.run(seconds):
            writer.write(frame)
    return path


def centres(character: Character, stage: Path) -> FloatArray:
    """Path (f, 3) m of the centre of mass, and that the body ends upright, from its stage alone."""
    masses, take = character.node_masses, read_take(stage)
    assert tilt(character.mesh.points, take.tet_points[-1], masses) < np.radians(5.0)
    assert abs(take.velocities[-1]).max() < 0.1
    path = np.einsum("n,fni->fi", masses / masses.sum(), take.tet_points)
    assert path[-1, 2] > 0.85 * path[0, 2]
    return np.asarray(path)


def test_letter_h_walks_jumps_balances_and_walks_back(tmp_path: Path) -> None:
    """As a scene file, whose stage tells how far it went and that it jumped."""
    motions = Sequence(
        [
            Motion(controller=Walk.for_(LETTER_H), distance=0.5),
            Motion(controller=Jump.for_(LETTER_H, height=0.05)),
            Motion(controller=Balance.for_(LETTER_H), seconds=1.5),
            Motion(controller=Walk.for_(LETTER_H, heading=math.pi), distance=0.25, name="back"),
            Balance.for_(LETTER_H),
        ]
    )
    scene = Scene(character=LETTER_H, ground=Plane())
    plan = ScenePlan(
        name="sequence",
        description="letter H goes there and back",
        scene=scene,
        controller=motions,
        seconds=11.5,
        time_step=1 / 60,
        settings={},
    )
    file = tmp_path / "sequence.toml"
    scene_files.write(file, plan)
    assert main(["check", str(file)]) == 0
    stage = tmp_path / "sequence.usdc"
    assert main(["run", str(file), "--out", str(stage), "--quiet"]) == 0
    path = centres(LETTER_H, stage)
    furthest = path[:, 0].max() - path[0, 0]
    assert 0.5 < furthest < 0.7
    assert -0.45 < path[-1, 0] - path[0, 0] - furthest < -0.2
    assert abs(path[:, 1] - path[0, 1]).max() < 0.1
    assert 0.02 < read_take(stage).tet_points[..., 2].min(axis=1).max() < 0.1


def test_letter_o_rolls_balances_and_rolls_back(tmp_path: Path) -> None:
    body = roll_o.rolling_letter()
    on_rim = Balance(
        BalanceGains(upright_weight=0.03, momentum_weight=0.02, spin_weight=0.003, base_weight=0.0),
        base="rim-0",
        head="rim-10",
        patches=("rim-18", "rim-19", "rim-0", "rim-1", "rim-2"),
    )
    turn = 2.0 * math.pi
    there, back = (
        Roll(roll_o.GAINS, legs=(Leg(direction=way, turn=turn),), rim="rim") for way in (1.0, -1.0)
    )
    motions = Sequence([there, Motion(controller=on_rim, seconds=2.0), back])
    path = centres(body, stage_of(tmp_path, body, motions, 26.0))
    furthest = path[:, 0].max() - path[0, 0]
    # half its height times the turn, but for what its rim is pressed flat
    assert furthest == pytest.approx(0.5 * turn, rel=0.15)
    assert path[-1, 0] - path[0, 0] == pytest.approx(0.0, abs=0.05)


def test_a_sequence_that_was_saved_goes_on_to_the_last_bit() -> None:
    """Saved within a motion, and restored in another simulation across two switches."""

    def made() -> Simulation:
        waving = Combined([Balance.for_(LETTER_H), Gesture(region="head_left")])
        motions: list[Motion | Controller] = [
            Motion(controller=Walk.for_(LETTER_H), seconds=0.3),
            Motion(controller=waving, seconds=0.2),
            Balance.for_(LETTER_H),
        ]
        scene = Scene(character=LETTER_H, ground=Plane())
        return Simulation(scene, Sequence(motions), time_step=1 / 60)

    first, second = made(), made()
    for _ in range(20):
        first.step()
    saved = first.save()
    second.restore(saved)
    for simulation in (first, second):
        for _ in range(25):
            simulation.step()
    one, other = (own.state.positions.numpy() for own in (first, second))
    np.testing.assert_array_equal(one, other)
    assert first.summary().motions == second.summary().motions
    assert [span.name for span in first.summary().motions] == ["walk", "combined", "balance"]
    assert first.goal_report().motion == "balance"
    assert "in the motion 'balance'" in str(first.goal_report())
    assert "walk from 0 s to 0.3 s, combined from 0.3 s" in str(first.summary())


@pytest.mark.long
def test_a_table_walks_jumps_and_balances_in_rounds(tmp_path: Path) -> None:
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", MeshWarning)
        body = Character.from_surface(BODIES["table"](), name="table")
    motions = Sequence(
        [
            Motion(controller=Walk.for_(body), distance=0.5),
            Motion(controller=Jump.for_(body, height=0.06)),
            Motion(controller=Balance.for_(body), seconds=1.0),
        ],
        rounds=3,
    )
    path = centres(body, stage_of(tmp_path, body, motions, 30.0))
    assert path[-1, 0] - path[0, 0] > 1.4
    assert [span.name for span in motions.course] == ["walk", "jump", "balance"] * 3
