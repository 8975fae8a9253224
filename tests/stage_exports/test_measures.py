"""Motions with known answers, measured on the file."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from warp_softbody import ContactSample, Frame, scenes
from warp_softbody.arrays import FloatArray
from warp_softbody.errors import InputError
from warp_softbody.stage_exports import StageWriter, measure, read_take, reversals
from warp_softbody.world.scene import Scene

# Stored in single precision, lengths near 1 m: a few millionths of what they are.
CLOSE = 2e-6


def turned(axis: int, degrees: float) -> FloatArray:
    cosine, sine = np.cos(np.radians(degrees)), np.sin(np.radians(degrees))
    matrix = np.eye(3)
    first, second = (axis + 1) % 3, (axis + 2) % 3
    matrix[[first, second], [first, second]] = cosine
    matrix[first, second], matrix[second, first] = -sine, sine
    return matrix


def test_a_take_reads_back_what_was_written(
    scene: Scene, make_frames: Any, write_take: Any
) -> None:
    take = read_take(write_take())
    frames = list(make_frames(scene))
    assert len(take) == len(frames) and take.name == "block" and take.ground == scene.ground
    np.testing.assert_allclose(take.color, scene.character.color, atol=1e-7)
    np.testing.assert_array_equal(take.tets, scene.character.mesh.tets)
    for index, frame in enumerate(frames):
        np.testing.assert_allclose(take.tet_points[index], frame.positions, atol=1e-7)
        np.testing.assert_allclose(take.velocities[index], frame.velocities, atol=1e-6)
        np.testing.assert_allclose(take.activations[index], frame.activations, atol=1e-7)
        np.testing.assert_allclose(take.contacts[index].forces, frame.contacts.forces)
        heads = frame.fiber_points[[0, 1, 2, 4, 5, 6]]
        np.testing.assert_allclose(take.fiber_points[index, :, 0], heads, atol=1e-7)


def test_rigid_translation(write_take: Any) -> None:
    speed = np.array([0.3, -0.2, 0.5])
    measures = measure(read_take(write_take(motion=lambda points, time: points + time * speed)))
    expected = np.array([0.0, 0.0, 0.2]) + np.arange(6)[:, None] / 30 * speed
    np.testing.assert_allclose(measures.centre_of_mass, expected, atol=CLOSE)
    np.testing.assert_allclose(measures.smallest_volume_ratio, 1.0, atol=1e-5)
    np.testing.assert_allclose(measures.volume_change, 0.0, atol=CLOSE)
    np.testing.assert_allclose(measures.tilt, 0.0, atol=1e-4)
    np.testing.assert_allclose(measures.base_area, 0.2 * 0.1, rtol=1e-5)
    assert measures.finite.all() and not measures.penetration.any()


def test_tilt_of_ten_degrees_does_not_count_spin(write_take: Any) -> None:
    def motion(points: FloatArray, time: float) -> FloatArray:
        share = 30.0 * time / 5.0
        return np.asarray(points @ (turned(0, 10.0 * share) @ turned(2, 80.0 * share)).T)

    measures = measure(read_take(write_take(motion=motion)))
    np.testing.assert_allclose(measures.tilt, np.linspace(0.0, 10.0, 6), atol=1e-4)
    projected = 0.02 * np.cos(np.radians(10.0))
    np.testing.assert_allclose(measures.base_area[-1], projected, rtol=1e-5)


def test_sunk_by_a_centimetre(write_take: Any) -> None:
    def motion(points: FloatArray, time: float) -> FloatArray:
        return np.asarray(points - np.array([0.0, 0.0, 0.01 * (time > 0.05)]))

    measures = measure(read_take(write_take(motion=motion)))
    np.testing.assert_allclose(measures.penetration, [0, 0, 0.01, 0.01, 0.01, 0.01], atol=1e-7)


def test_stretch_and_inverted_tet(write_take: Any) -> None:
    def motion(points: FloatArray, time: float) -> FloatArray:
        moved: FloatArray = points * np.array([1.0, 1.0, 1.0 + 3.0 * time])
        if time > 0.15:
            moved[int(np.argmax(points.sum(axis=1)))] -= 0.5
        return moved

    measures = measure(read_take(write_take(motion=motion)))
    np.testing.assert_allclose(measures.volume_change[:5], 3.0 * np.arange(5) / 30, atol=1e-5)
    np.testing.assert_allclose(measures.smallest_volume_ratio[1], 1.1, rtol=1e-5)
    assert measures.smallest_volume_ratio[5] < 0.0


@pytest.mark.parametrize("content", [None, b"", b"not a stage", b"#usda 1.0\n"])
def test_other_files_are_refused_in_one_sentence(tmp_path: Any, content: bytes | None) -> None:
    path = tmp_path / "other.usda"
    if content is not None:
        path.write_bytes(content)
    with pytest.raises(InputError, match=r"other\.usda"):
        read_take(path)


def test_reversals_of_a_shaken_and_of_a_thrown_body(tmp_path: Path) -> None:
    """A velocity that swings every other frame reverses always, a steady pull never does.

    Nor does one that swings by what rounding leaves, here by 2.5e-6 m/s along each axis.
    """
    scene = scenes.make("drop-block").scene
    points = scene.character.mesh.points
    swings = {"swing": 1.0, "faint": 1e-5, "rounding": 2.5e-6}
    cases = (("swing", 1.0), ("faint", 1.0), ("rounding", 0.0), ("pull", 0.0))
    for name, expected in cases:
        path = tmp_path / f"{name}.usdc"
        with StageWriter(path, scene, fps=60.0) as stage:
            for index in range(10):
                speed = swings[name] * (-1.0) ** index if name in swings else 0.1 * index
                velocities = np.full(points.shape, speed)
                stage.write(
                    Frame(
                        index=index,
                        time=index / 60.0,
                        positions=points,
                        velocities=velocities,
                        activations=np.zeros(0),
                        fiber_points=np.zeros((0, 3)),
                        contacts=ContactSample(),
                    )
                )
        assert reversals(read_take(path)) == expected


def test_a_body_without_volume_is_refused_and_a_flat_sliver_is_passed_over(
    write_take: Any,
) -> None:
    take = read_take(write_take())
    with pytest.raises(InputError, match="'block' cannot be measured: its volume at rest is 0"):
        measure(replace(take, rest=take.rest * (1.0, 1.0, 0.0)))
    sliver = replace(take, tets=np.concatenate([take.tets, [[0, 1, 1, 2]]]).astype(np.int32))
    np.testing.assert_allclose(
        measure(sliver).smallest_volume_ratio, measure(take).smallest_volume_ratio
    )
