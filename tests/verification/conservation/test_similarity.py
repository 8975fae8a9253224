"""A body of any size moves as one of a metre does, scaled: no speed or length is built in."""

from __future__ import annotations

import numpy as np
import pytest

from tests.support.bodies import box, turned
from warp_softbody import (
    Body,
    Character,
    Material,
    Plane,
    Scene,
    Simulation,
    SimulationOptions,
    TetMesh,
    placed,
)
from warp_softbody.arrays import FloatArray


def block(size: float, height: float) -> Character:
    """Cells of a quarter of the size, tilted, above the ground by a share of the size."""
    mesh = box((4, 2, 2), (size, 0.5 * size, 0.5 * size))
    points = turned(mesh.points, (1.0, 0.2, 0.0), np.radians(20.0))
    points[:, 2] += height * size - points[:, 2].min()
    material = Material(
        young_modulus=2e5 * size,
        poisson_ratio=0.4,
        density=1000.0,
        stiffness_damping=0.02 * np.sqrt(size),
    )
    return Character(name="block", mesh=TetMesh.from_arrays(points, mesh.tets), material=material)


def path(scene: Scene, size: float) -> tuple[FloatArray, Simulation]:
    """Places of all nodes over a scaled second and a half, in units of the size."""
    scaled = np.sqrt(size)
    options = SimulationOptions(time_step=0.01 * scaled, precision="float64")
    simulation = Simulation(scene, options=options, fps=20.0 / scaled)
    frames = [frame.positions / size for frame in simulation.run(1.5 * scaled)]
    return np.array(frames), simulation


@pytest.mark.parametrize("size", [1e-4, 4e-4, 0.02, 10.0])
def test_a_thrown_block(size: float) -> None:
    """It falls on an edge, tips over, slides and comes to rest."""

    def scene(of: float) -> Scene:
        return Scene(
            character=block(of, 0.3),
            ground=Plane(friction=0.4),
            initial_velocity=(1.5 * np.sqrt(of), 0.0, 0.0),
        )

    expected, _ = path(scene(1.0), 1.0)
    found, simulation = path(scene(size), size)
    summary = simulation.summary()
    assert summary.findings.doubts == () and summary.unconverged_steps == 0
    # contact hangs on digits, so that rounding grows from bounce to bounce
    assert np.abs(found - expected).max() < 0.01


@pytest.mark.parametrize("size", [4e-4, 0.02])
def test_one_on_another(size: float) -> None:
    """Pairs of surfaces, at rest on each other after a fall."""

    def scene(of: float) -> Scene:
        lower = Character(
            name="lower",
            mesh=box((3, 3, 1), (of, of, 0.3 * of), (-0.2 * of, -0.2 * of, 0.0)),
            material=Material(young_modulus=2e5 * of, stiffness_damping=0.02 * np.sqrt(of)),
        )
        upper = placed(block(of, 0.05), translation=(0.0, 0.0, 0.3 * of))
        return Scene(character=upper, others=(Body(character=lower),), ground=Plane())

    expected, _ = path(scene(1.0), 1.0)
    found, simulation = path(scene(size), size)
    assert simulation.summary().findings.doubts == ()
    assert np.abs(found - expected).max() < 0.05
