"""Sequences of motions from perturbed starts."""

from __future__ import annotations

import math

import numpy as np
import pytest

from benchmarks import sequences
from warp_softbody.run.falls import tilt
from warp_softbody.world.ground import Plane


@pytest.mark.parametrize("name", list(sequences.PROGRAMMES))
def test_starts_differ_by_seed_and_within_what_is_told(name: str) -> None:
    programme = sequences.PROGRAMMES[name]
    scenes = [sequences.perturbed(programme, seed, 20.0) for seed in (0, 0, 1)]
    assert scenes[0] == scenes[1] != scenes[2]
    body = scenes[0].character
    for scene in scenes:
        assert isinstance(scene.ground, Plane) and 0.64 <= scene.ground.friction <= 0.96
        pose = scene.initial_pose
        assert pose is not None
        assert tilt(body.mesh.points, pose, body.node_masses) <= math.radians(1.0) + 1e-9
        assert 0.0 <= pose[:, 2].min() <= 0.005
        assert len(scene.pushes) == 10 and len(programme.motions(body)) == 4
        weight = body.material.density * body.mesh.volume * 9.81
        sizes = [np.linalg.norm(push.force) / weight for push in scene.pushes]
        np.testing.assert_allclose(sizes, 0.02, rtol=1e-9)


def test_letter_x_takes_four_motions(capsys: pytest.CaptureFixture[str]) -> None:
    sequences.main(["letter-x", "--seeds", "1", "--rounds", "1"])
    out = capsys.readouterr().out
    assert "letter-x: 1 of 1 hold" in out and "4 of 4" in out


def test_what_did_not_end_or_lies_does_not_hold() -> None:
    done = sequences.SequenceEnd(4, 4, 6.0, 2.0, 5.0, "back")
    assert done.holds
    assert not done._replace(motions=3).holds and not done._replace(leaning=80.0).holds
