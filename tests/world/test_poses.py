"""Bodies may start in a pose of their own."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from tests.support.bodies import box, numbers
from warp_softbody import (
    Body,
    Character,
    Material,
    Scene,
    Simulation,
    SimulationOptions,
    scene_files,
)
from warp_softbody.engine.energies import EnergyMeter
from warp_softbody.errors import InputError
from warp_softbody.scenes.plan import ScenePlan
from warp_softbody.world.refined_scene import refined_scene
from warp_softbody.world.similar_scene import Similarity, similar_scene

SOFT = Material(young_modulus=1e4, poisson_ratio=0.0, stiffness_damping=0.0)


def block(name: str = "block", at: float = 0.0) -> Character:
    return Character(name=name, mesh=box(origin=(at, 0.0, 0.0)), material=SOFT)


def stretched(
    body: Character, by: float = 1.1
) -> np.ndarray[tuple[int, ...], np.dtype[np.float64]]:
    """Its nodes, stretched along z."""
    return np.asarray(body.mesh.points * (1.0, 1.0, by))


def test_a_stretched_body_has_its_energy_and_lets_it_go() -> None:
    """E e^2 / 2 a volume at the start, with nu = 0; then it moves, and its middle stays."""
    body, other = block(), block("other", 1.0)
    scene = Scene(
        character=body,
        others=(Body(character=other, pose=stretched(other, 0.95)),),
        gravity=(0.0, 0.0, 0.0),
        initial_pose=stretched(body),
    )
    simulation = Simulation(
        scene, options=SimulationOptions(precision="float64", time_step=1e-3), fps=1000.0
    )
    positions = numbers(simulation.state.positions)
    np.testing.assert_array_equal(positions, scene.start_points)
    still = np.zeros_like(positions)
    energies = EnergyMeter(simulation.model).measure(positions, still, np.zeros(0)).elastic
    volume = body.mesh.volume
    expected = [0.5 * SOFT.young_modulus * e**2 * volume for e in (0.1, 0.05)]
    np.testing.assert_allclose(energies, expected, rtol=1e-9)
    masses = simulation.model.masses
    middle = masses @ positions / masses.sum()
    for _ in range(20):
        simulation.step()
    after = numbers(simulation.state.positions)
    np.testing.assert_allclose(masses @ after / masses.sum(), middle, atol=1e-9)
    assert np.abs(after - positions).max() > 1e-4


def test_poses_are_refined_scaled_and_written(tmp_path: Path) -> None:
    body = block()
    scene = Scene(character=body, initial_pose=stretched(body))
    fine = refined_scene(scene, 1)
    np.testing.assert_allclose(fine.start_points, stretched(fine.character), atol=1e-15)
    large = similar_scene(scene, Similarity(length=4.0))
    np.testing.assert_array_equal(large.start_points, 4.0 * scene.start_points)
    plan = ScenePlan(
        name="own",
        description="stretched",
        scene=scene,
        controller=None,
        seconds=1.0,
        time_step=0.01,
        settings={},
    )
    scene_files.write(tmp_path / "own.toml", plan)
    assert scene_files.read(tmp_path / "own.toml").plan.scene == scene
    np.save(tmp_path / "own_files" / "block_pose.npy", np.zeros((2, 3)))
    with pytest.raises(InputError, match=r"character\.pose: .*of shape .27, 3."):
        scene_files.read(tmp_path / "own.toml")


def test_a_pose_of_another_body_is_refused() -> None:
    with pytest.raises(InputError, match=r"Scene\.initial_pose must be an array of finite numbers"):
        Scene(character=block(), initial_pose=np.zeros((3, 3)))
    with pytest.raises(InputError, match=r"Body\.pose"):
        Body(character=block(), pose=np.full((27, 3), np.nan))
