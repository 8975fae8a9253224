"""Force fields move bodies as their closed forms say."""

from __future__ import annotations

import math
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from tests.support.bodies import box, muscular_bar, numbers
from warp_softbody import (
    Body,
    Character,
    DragField,
    ForceField,
    Material,
    RadialField,
    Scene,
    Simulation,
    SimulationOptions,
    UniformField,
    scene_files,
)
from warp_softbody.arrays import FloatArray
from warp_softbody.errors import InputError
from warp_softbody.scenes.plan import ScenePlan
from warp_softbody.world.similar_scene import Similarity, similar_scene

DT = 0.01


def body(name: str = "body", at: tuple[float, float, float] = (0.0, 0.0, 0.0)) -> Character:
    """A small cube about a place."""
    size = 0.02
    corner = tuple(each - 0.5 * size for each in at)
    mesh = box((1, 1, 1), (size,) * 3, corner)  # type: ignore[arg-type]
    return Character(name=name, mesh=mesh, material=Material(young_modulus=1e6))


def simulation(*fields: ForceField, dt: float = DT, **given: Any) -> Simulation:
    usual: dict[str, Any] = {"character": body(), "gravity": (0.0, 0.0, 0.0), "fields": fields}
    scene = Scene(**(usual | given))
    options = SimulationOptions(precision="float64", time_step=dt)
    return Simulation(scene, options=options, fps=1.0 / dt)


def mean_of(simulated: Simulation, array: str, number: int = 0) -> FloatArray:
    """Mean of "positions" or "velocities" of a body, by mass."""
    part = simulated.model.scene.parts[number]
    masses = simulated.model.masses[part.nodes]
    values = numbers(getattr(simulated.state, array))[part.nodes]
    return np.asarray(masses @ values / masses.sum())


def test_uniform_field_acts_while_it_lasts() -> None:
    field = UniformField(acceleration=(2.0, 0.0, 0.0), start=0.105, duration=0.5)
    moved = simulation(field)
    for _ in range(100):
        moved.step()
    np.testing.assert_allclose(mean_of(moved, "velocities"), (1.0, 0.0, 0.0), atol=1e-9)


def test_swinging_field_gives_the_integral_of_its_cosine() -> None:
    moved = simulation(UniformField(acceleration=(0.0, 3.0, 0.0), period=0.7))
    for _ in range(37):
        moved.step()
    rate = 2.0 * math.pi / 0.7
    expected = 3.0 * math.sin(rate * moved.time) / rate
    assert mean_of(moved, "velocities")[1] == pytest.approx(expected, abs=1e-9)


def test_drag_decays_exactly_at_any_step() -> None:
    """V - w falls as exp(-rate t), though rate dt is three."""
    moved = simulation(
        DragField(rate=30.0, wind=(1.0, 0.0, 0.0)), dt=0.1, initial_velocity=(3.0, 2.0, 0.0)
    )
    for _ in range(3):
        moved.step()
    left = math.exp(-30.0 * 0.3)
    expected = (1.0 + 2.0 * left, 2.0 * left, 0.0)
    np.testing.assert_allclose(mean_of(moved, "velocities"), expected, atol=1e-9)


def test_body_circles_a_centre() -> None:
    """On a circle of 1 m under a = -4 / r^2 the speed is 2 m/s and a turn lasts pi s.

    The error of a symplectic first-order step is of the order of the angle of a step, 0.02.
    """
    field = RadialField(center=(0.0, 0.0, 0.0), acceleration=-16.0, distance=0.5)
    moved = simulation(field, character=body(at=(1.0, 0.0, 0.0)), initial_velocity=(0.0, 2.0, 0.0))
    for _ in range(314):
        moved.step()
        place, speed = mean_of(moved, "positions"), mean_of(moved, "velocities")
        assert np.linalg.norm(place) == pytest.approx(1.0, abs=0.02)
        assert np.cross(place, speed)[2] == pytest.approx(2.0, rel=1e-3)
    np.testing.assert_allclose(place, (1.0, 0.0, 0.0), atol=0.05)


def test_radial_field_is_finite_at_its_centre() -> None:
    field = RadialField(center=(1.0, 0.0, 0.0), acceleration=2.0, distance=0.5, power=1.0)
    points = np.array([(1.0, 0.0, 0.0), (1.25, 0.0, 0.0), (1.0, 0.5, 0.0), (1.0, 0.0, 2.0)])
    expected = [(0.0, 0.0, 0.0), (1.0, 0.0, 0.0), (0.0, 2.0, 0.0), (0.0, 0.0, 8.0)]
    np.testing.assert_allclose(field.accelerations(points, points, DT), expected, atol=1e-12)


def test_field_of_a_body_leaves_the_others_alone() -> None:
    other = Body(character=body("other", (1.0, 0.0, 0.0)))
    field = UniformField(acceleration=(0.0, 0.0, 1.0), region="other")
    moved = simulation(field, others=(other,))
    for _ in range(10):
        moved.step()
    np.testing.assert_allclose(mean_of(moved, "velocities", 0), 0.0, atol=1e-12)
    np.testing.assert_allclose(mean_of(moved, "velocities", 1), (0.0, 0.0, 0.1), atol=1e-9)


def test_fields_keep_bodies_awake_and_scale() -> None:
    fields = (
        UniformField(acceleration=(1.0, 0.0, 0.0), start=1.0, period=2.0),
        RadialField(center=(1.0, 2.0, 0.0), acceleration=3.0, distance=0.5, duration=4.0),
        DragField(rate=2.0, wind=(1.0, 0.0, 0.0)),
    )
    scene = Scene(character=body(), fields=fields)
    by, back = Similarity(length=4.0, gravity=0.25), Similarity(length=0.25, gravity=4.0)
    other = similar_scene(scene, by)
    assert other.fields[1] == RadialField(
        center=(4.0, 8.0, 0.0), acceleration=0.75, distance=2.0, duration=16.0
    )
    assert similar_scene(other, back) == scene
    still = simulation(DragField(rate=1.0))
    for _ in range(100):
        still.step()
    assert not still.asleep


def test_files_hold_fields(tmp_path: Path) -> None:
    fields = (
        UniformField(acceleration=(1.0, 0.0, 0.0), start=1.0, period=2.0, region="top"),
        RadialField(center=(1.0, 2.0, 0.0), acceleration=3.0, distance=0.5, duration=4.0),
        DragField(rate=2.0, wind=(1.0, 0.0, 0.0)),
    )
    plan = ScenePlan(
        name="own",
        description="fields",
        scene=Scene(character=muscular_bar(), fields=fields),
        controller=None,
        seconds=1.0,
        time_step=0.01,
        settings={},
    )
    scene_files.write(tmp_path / "own.toml", plan)
    assert scene_files.read(tmp_path / "own.toml").plan.scene == plan.scene
    wrong = '[character]\nshape = "ball"\nradius = 1.0\n[[fields]]\nkind = "uniform"\n'
    for more, sentence in (
        ("", "4: fields.0.: the key 'acceleration' is missing"),
        ("acceleration = [1, 0, 0]\nregion = 'b'\n", "7: fields.0..region: no region or body"),
        ("acceleration = 1\n", "6: fields.0..acceleration: UniformField.acceleration must be 3"),
    ):
        (tmp_path / "wrong.toml").write_text(wrong + more)
        with pytest.raises(InputError, match=sentence):
            scene_files.read(tmp_path / "wrong.toml")


def test_wrong_fields_are_refused() -> None:
    with pytest.raises(InputError, match="no region or body of the scene is named 'none'"):
        Scene(character=body(), fields=(UniformField(acceleration=(1, 0, 0), region="none"),))
    with pytest.raises(InputError, match=r"DragField\.rate"):
        DragField(rate=-1.0)
    with pytest.raises(InputError, match=r"RadialField\.distance"):
        RadialField(center=(0, 0, 0), acceleration=1.0, distance=0.0)
