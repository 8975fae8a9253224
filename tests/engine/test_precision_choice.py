"""Single precision is taken where its rounding hides nothing."""

from __future__ import annotations

import pytest

from tests.support.bodies import box
from warp_softbody import (
    Character,
    Material,
    Plane,
    Scene,
    Simulation,
    SimulationOptions,
    build_model,
    scenes,
)
from warp_softbody.engine.precision_choice import choose_precision, with_precision


def cube(young_modulus: float, *, place: float = 0.0, damping: float = 0.05) -> Character:
    material = Material(young_modulus=young_modulus, poisson_ratio=0.3, stiffness_damping=damping)
    mesh = box((5, 5, 5), (0.1, 0.1, 0.1), (place, 0.0, 0.0))
    return Character(name="cube", mesh=mesh, material=material)


@pytest.mark.parametrize("name", scenes.names())
def test_every_shipped_scene_takes_float32(name: str) -> None:
    plan = scenes.make(name, {})
    assert choose_precision(plan.scene, plan.time_step) == "float32"


@pytest.mark.parametrize(
    ("young_modulus", "place", "damping", "time_step", "expected"),
    [
        (1e6, 0.0, 0.05, 1e-2, "float32"),
        # the weight's pressure is a thousand pascals
        (1e9, 0.0, 0.05, 1e-2, "float64"),
        # positions are rounded to 0.06 mm
        (1e6, 1000.0, 0.05, 1e-2, "float64"),
        # the mass is lost beside the stiffness
        (1e8, 0.0, 1e3, 1e-2, "float64"),
        # what gravity adds in a step is little more than rounding of positions over it
        (1e4, 1.0, 0.0, 1e-4, "float64"),
    ],
)
def test_what_rounding_would_hide(
    young_modulus: float, place: float, damping: float, time_step: float, expected: str
) -> None:
    body = cube(young_modulus, place=place, damping=damping)
    scene = Scene(character=body, ground=Plane())
    assert choose_precision(scene, time_step) == expected
    options = SimulationOptions(time_step=time_step)
    assert build_model(scene, options).options.precision == expected


def test_what_is_asked_for_is_kept() -> None:
    scene = Scene(character=cube(1e9), ground=Plane())
    options = SimulationOptions(precision="float32")
    assert with_precision(options, scene) is options
    simulation = Simulation(scene, options=options)
    for _ in simulation.run(0.05):
        pass
    summary = simulation.summary()
    assert summary.precision == "float32" and summary.status == "doubtful"
    (doubt,) = summary.findings.doubts
    assert "float32 rounds away" in doubt and "take precision float64" in doubt
