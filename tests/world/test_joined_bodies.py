"""Several bodies in one scene: joined for the engine, each as it would be alone."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np
import pytest

from tests.support.bodies import box, epsilon, muscular_bar
from warp_softbody import Material, Plane, Push, Scene, Simulation, SimulationOptions
from warp_softbody.body.character import Character
from warp_softbody.body.material import Volume
from warp_softbody.engine.options import Precision
from warp_softbody.errors import InputError
from warp_softbody.world.joined_bodies import Body, join, placed

SOFT = Material(young_modulus=2e4, poisson_ratio=0.3, stiffness_damping=0.01, mass_damping=0.2)
STIFF = Material(young_modulus=3e5, poisson_ratio=0.45, stiffness_damping=0.03, density=500.0)


def block(name: str, material: Material, at: tuple[float, float, float]) -> Character:
    mesh = box((2, 2, 2), (0.2, 0.2, 0.2))
    regions = {"top": np.flatnonzero(mesh.points[:, 2] > 0.199).astype(np.int32)}
    body = Character(name=name, mesh=mesh, material=material, regions=regions)
    return placed(body, translation=at)


def end_of(scene: Scene, **options: Any) -> tuple[Any, Any]:
    simulation = Simulation(scene, options=SimulationOptions(time_step=0.01, **options), fps=100.0)
    *_, last = simulation.run(0.3)
    return last.positions, last.velocities


@pytest.mark.parametrize(
    "options",
    [
        {"precision": "float64"},
        {"precision": "float32"},
        {"precision": "float64", "elements": "smoothed"},
        {"precision": "float64", "tangent": "conserving", "newton_iterations": 2},
        {"precision": "float64", "tangent": "exact"},
        {"precision": "float64", "threads": 2},
    ],
    ids=["double", "single", "smoothed", "newton", "exact", "threads"],
)
@pytest.mark.parametrize("volume", ["linear", "exact"])
def test_each_body_moves_as_if_alone(volume: Volume, options: dict[str, Any]) -> None:
    """Two materials, far apart, one dropped and one thrown: nothing but rounding joins them.

    One may resist its exact change of volume, the other never does. Both solves stop at a relative
    residual of 1e-10 (1e-6 in single precision) of the momenta of the bodies solved together; 30
    steps add up.
    """
    precision: Precision = options["precision"]
    stiff = replace(STIFF, volume=volume)
    first, second = block("a", SOFT, (0.0, 0.0, 0.01)), block("b", stiff, (2.0, 0.0, 0.05))
    thrown = (0.5, 0.0, 0.3)
    # friction obeys its law by 5 % only while sliding speeds change (docs/contact.md)
    ground = Plane(friction=0.0)
    tolerance = {"tolerance": 1e-10 if precision == "float64" else 1e-6}
    both, speeds = end_of(
        Scene(character=first, others=(Body(character=second, velocity=thrown),), ground=ground),
        **options,
        **tolerance,
    )
    alone_a, speeds_a = end_of(Scene(character=first, ground=ground), **options, **tolerance)
    alone_b, speeds_b = end_of(
        Scene(character=second, ground=ground, initial_velocity=thrown), **options, **tolerance
    )
    # speeds are of the order of 1 m/s; contact's own zero is 1e-5 m/s (docs/contact.md)
    close = 30 * 1e-10 + 1e-5 if precision == "float64" else 30 * 1e-6 + 1e-4
    np.testing.assert_allclose(speeds, np.concatenate([speeds_a, speeds_b]), atol=close)
    np.testing.assert_allclose(both, np.concatenate([alone_a, alone_b]), atol=close)


def test_muscles_of_each_body_pull_only_in_it() -> None:
    """The weights of a segment stay in its own body, whose tets are numbered after the first's."""
    bar = muscular_bar()
    pair = Scene(
        character=bar,
        others=(Body(character=placed(bar, name="twin", translation=(0.0, 3.0, 0.0))),),
    )
    model = Simulation(pair).model
    one, two = pair.parts
    assert two.segments == slice(bar.segment_count, 2 * bar.segment_count)
    layout = model.muscles
    in_second = layout.pair_segment >= two.segments.start
    assert (layout.pair_tet[in_second] >= two.tets.start).all()
    assert (layout.pair_tet[~in_second] < one.tets.stop).all()
    np.testing.assert_allclose(
        layout.rest_lengths[: bar.segment_count], layout.rest_lengths[bar.segment_count :]
    )


def test_placing_turns_and_moves_everything() -> None:
    bar = muscular_bar()
    shift = np.array([0.3, -0.2, 1.0])
    there = placed(bar, translation=tuple(shift), axis=(0.0, 0.0, 2.0), degrees=90.0)
    quarter = np.array([[0.0, -1.0, 0.0], [1.0, 0.0, 0.0], [0.0, 0.0, 1.0]])
    rounding = 8.0 * epsilon("float64") * np.abs(there.mesh.points).max()
    np.testing.assert_allclose(
        there.mesh.points, bar.mesh.points @ quarter.T + shift, atol=rounding
    )
    for old, new in zip(bar.fibers, there.fibers, strict=True):
        np.testing.assert_allclose(new.vertices, old.vertices @ quarter.T + shift, atol=rounding)
    assert there.name == bar.name


def test_regions_of_others_are_named_after_them() -> None:
    first, second = block("a", SOFT, (0.0, 0.0, 0.0)), block("b", SOFT, (1.0, 0.0, 0.0))
    whole = join([first, second])
    nodes = len(first.mesh.points)
    np.testing.assert_array_equal(whole.region("b.top"), second.region("top") + nodes)
    np.testing.assert_array_equal(whole.region("top"), first.region("top"))
    push = Push(region="b.top", force=(3.0, 0.0, 0.0), start=0.0, duration=1.0)
    scene = Scene(
        character=first, others=(Body(character=second),), gravity=(0.0, 0.0, 0.0), pushes=(push,)
    )
    _, speeds = end_of(scene, precision="float64", tolerance=1e-10)
    # forces at rest are rounding: E h^2 eps times dt / m, below 1e-12 m/s
    assert np.abs(speeds[:nodes]).max() < 1e-12
    assert speeds[nodes:, 0].mean() > 0.05


@pytest.mark.parametrize(
    ("make", "sentence"),
    [
        (
            lambda a: Scene(character=a, others=(Body(character=a),)),
            "two bodies of the scene have the name 'a'",
        ),
        (
            lambda a: Body(character=a, velocity=(np.nan, 0.0, 0.0)),
            "Body.velocity must be 3 finite numbers",
        ),
        (lambda a: Scene(character=a, body_friction=-1.0), "body_friction"),
        (
            lambda a: placed(a, axis=(0.0, 0.0, 0.0)),
            "axis of placed must be a vector that is not zero",
        ),
    ],
)
def test_mistakes(make: Any, sentence: str) -> None:
    with pytest.raises(InputError, match=sentence):
        make(block("a", SOFT, (0.0, 0.0, 0.0)))


def test_a_scene_of_one_body_is_that_body() -> None:
    """No copy of the mesh, so that scenes cost what they did."""
    only = block("a", SOFT, (0.0, 0.0, 0.0))
    assert Scene(character=only).whole is only
    assert not Scene(character=only).has_pairs
    assert replace(Scene(character=only), self_contact=True).has_pairs
