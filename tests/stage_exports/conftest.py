"""A small body with two muscles, and motions of it with known answers."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from pathlib import Path

import numpy as np
import pytest

from tests.stage_exports.crowd import FRAMES, frame_at, make_crowd
from warp_softbody.arrays import FloatArray
from warp_softbody.body.character import Character
from warp_softbody.body.mesh import TetMesh
from warp_softbody.body.muscles import Fiber, FiberKind, MuscleGroup
from warp_softbody.contact_mode import ContactMode
from warp_softbody.stage_exports import StageWriter
from warp_softbody.world.frame import ContactSample, Frame
from warp_softbody.world.ground import Plane
from warp_softbody.world.scene import Scene

RecordedMotion = Callable[[FloatArray, float], FloatArray]
MakeFrames = Callable[..., Iterator[Frame]]
WriteTake = Callable[..., Path]

SIZE = np.array([0.2, 0.1, 0.4])
_CELLS = (2, 1, 4)
_SPLIT = ((0, 4, 6, 7), (0, 6, 2, 7), (0, 2, 3, 7), (0, 3, 1, 7), (0, 1, 5, 7), (0, 5, 4, 7))


def _block() -> TetMesh:
    """A box on the ground, six tets a cell."""
    ticks = [np.linspace(0.0, 1.0, count + 1) for count in _CELLS]
    points = np.stack(np.meshgrid(*ticks, indexing="ij"), axis=-1).reshape(-1, 3) * SIZE
    shape = tuple(count + 1 for count in _CELLS)
    corners = np.array(
        [
            [
                np.ravel_multi_index((i + a, j + b, k + c), shape)
                for a in (0, 1)
                for b in (0, 1)
                for c in (0, 1)
            ]
            for i in range(_CELLS[0])
            for j in range(_CELLS[1])
            for k in range(_CELLS[2])
        ]
    )
    tets = corners[:, np.array(_SPLIT)].reshape(-1, 4)
    return TetMesh.from_arrays(points - SIZE * (0.5, 0.5, 0.0), tets)


def _fiber(name: str, x: float) -> Fiber:
    heights = np.linspace(0.05, 0.35, 4)
    vertices = np.stack([np.full(4, x), np.zeros(4), heights], axis=1)
    return Fiber(vertices=vertices, kind=FiberKind.LONGITUDINAL, name=name)


@pytest.fixture
def scene() -> Scene:
    """A block with two fibres of three segments each, on a plane."""
    group = MuscleGroup(
        fibers=(_fiber("left", -0.05), _fiber("right", 0.05)),
        strength=1e5,
        kernel_width=0.1,
        name="both",
    )
    character = Character(name="block", mesh=_block(), muscles=(group,))
    return Scene(character=character, ground=Plane(friction=0.7))


def _sway(points: FloatArray, time: float) -> FloatArray:
    bent = np.sin(3.0 * time) * points[:, 2:] ** 2 * np.array([1.0, 0.0, 0.0])
    return np.asarray(points + bent)


@pytest.fixture
def make_frames() -> MakeFrames:
    """Frames of a scene in which every material point follows `motion(points, time)`."""

    def make(
        scene: Scene, count: int = 6, motion: RecordedMotion = _sway, fps: float = 30.0
    ) -> Iterator[Frame]:
        character = scene.character
        rest = character.mesh.points
        vertices = np.concatenate([*(f.vertices for f in character.fibers), np.zeros((0, 3))])
        for index in range(count):
            time = index / fps
            positions = motion(rest, time)
            touching = positions[: index % 3]
            yield Frame(
                index=index,
                time=time,
                positions=positions,
                velocities=(motion(rest, time + 1e-5) - motion(rest, time - 1e-5)) / 2e-5,
                activations=np.linspace(1.0, 0.5, character.segment_count) ** (index / count),
                fiber_points=motion(vertices, time),
                contacts=ContactSample(
                    points=touching,
                    modes=np.full(len(touching), ContactMode.STICK, dtype=np.int32),
                    forces=np.tile([0.0, 0.0, 2.0], (len(touching), 1)),
                ),
            )

    return make


@pytest.fixture
def write_take(scene: Scene, make_frames: MakeFrames, tmp_path: Path) -> WriteTake:
    """Write a take of the block and return its path."""

    def write(name: str = "take.usdc", motion: RecordedMotion = _sway, count: int = 6) -> Path:
        path = tmp_path / name
        with StageWriter(path, scene, fps=30) as stage:
            for frame in make_frames(scene, count, motion):
                stage.write(frame)
        return path

    return write


@pytest.fixture
def crowd() -> Scene:
    """Several bodies on a plane."""
    return make_crowd()


@pytest.fixture
def write_crowd(crowd: Scene, tmp_path: Path) -> WriteTake:
    """Write a take of several bodies, in chunks, and return its path."""

    def write(name: str = "crowd.usdc") -> Path:
        with StageWriter(tmp_path / name, crowd, fps=30, chunk_frames=2) as stage:
            for index in range(FRAMES):
                stage.write(frame_at(crowd, index))
        return tmp_path / name

    return write
