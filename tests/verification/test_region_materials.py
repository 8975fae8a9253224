"""Bodies of two materials: a bar of two halves bends as the composite beam of both."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from tests.support.bodies import box, muscular_bar, numbers
from warp_softbody import (
    Character,
    Material,
    Push,
    Scene,
    Simulation,
    SimulationOptions,
    scene_files,
)
from warp_softbody.engine.energies import EnergyMeter
from warp_softbody.errors import InputError
from warp_softbody.scenes.plan import ScenePlan

LENGTH, SIDE = 1.0, 0.1  # m
SOFT, HARD = 1e5, 4e5  # Pa
AREA, INERTIA = SIDE**2, SIDE**4 / 12.0
SHEAR = 5.0 / 6.0
"""Of a rectangle's area, what bears shear (Timoshenko)."""


def material(young_modulus: float, density: float = 1.0) -> Material:
    """With nu = 0, so that beams need no thought of the width."""
    return Material(
        young_modulus=young_modulus, poisson_ratio=0.0, density=density, stiffness_damping=0.0
    )


def bar(layers: bool, cells: tuple[int, int, int] = (40, 4, 8)) -> Character:
    """Clamped at x = 0; its hard half is the upper one, or the outer one."""
    mesh = box(cells, (LENGTH, SIDE, SIDE))
    x, _, z = mesh.points.T
    hard: Any = z > 0.5 * SIDE - 1e-9 if layers else x > 0.5 * LENGTH - 1e-9
    regions: dict[str, Any] = {"hard": hard, "tip": x > LENGTH - 1e-9}
    clamped: Any = x < 1e-9
    return Character(
        name="bar",
        mesh=mesh,
        material=material(SOFT),
        regions=regions,
        fixed=clamped,
        materials={"hard": material(HARD)},
    )


def stiffness_of_layers() -> float:
    """E I of two layers about their common neutral axis, N m^2."""
    half, moduli = 0.5 * SIDE, np.array([SOFT, HARD])
    middles = half * np.array([0.5, 1.5])
    axis = moduli @ middles / moduli.sum()
    own = SIDE * half**3 / 12.0 + SIDE * half * (middles - axis) ** 2
    return float(moduli @ own)


def beam(layers: bool) -> float:
    """Deflection of the tip by a force of 1 N, m: bending and shear, G = E / 2."""
    if layers:
        bending = LENGTH**3 / (3.0 * stiffness_of_layers())
        return bending + LENGTH / (SHEAR * AREA * 0.25 * (SOFT + HARD))
    half = 0.5 * LENGTH
    bending = (half**3 / HARD + (LENGTH**3 - half**3) / SOFT) / (3.0 * INERTIA)
    return bending + half * (2.0 / SOFT + 2.0 / HARD) / (SHEAR * AREA)


def bent(body: Character, force: float) -> tuple[float, Simulation]:
    """Deflection of the tip at rest, m; a step of 1000 s is one of Newton's method in statics."""
    push = Push(region="tip", force=(0.0, 0.0, -force), start=0.0, duration=1e9)
    options = SimulationOptions(
        time_step=1e3, precision="float64", elements="smoothed", sleep=False
    )
    scene = Scene(character=body, gravity=(0.0, 0.0, 0.0), pushes=(push,))
    simulation = Simulation(scene, options=options, fps=1e-3)
    for _ in range(30):
        simulation.step()
    tip = body.region("tip")
    return float(
        (body.mesh.points - numbers(simulation.state.positions))[tip, 2].mean()
    ), simulation


@pytest.mark.parametrize("layers", [True, False], ids=["layers", "halves"])
def test_bar_of_two_halves_bends_as_the_composite_beam(layers: bool) -> None:
    """To 1 % of Timoshenko's beam; the tip moves by 1 mm, so that the beam is linear to 1e-5."""
    force = 1e-3 / beam(layers)
    deflection, simulation = bent(bar(layers), force)
    assert deflection == pytest.approx(1e-3, rel=1e-2)
    # Clapeyron: the energy stored is half of what the force would do at its full size
    still = np.zeros((simulation.model.node_count, 3))
    meter = EnergyMeter(simulation.model)
    stored = meter.measure(numbers(simulation.state.positions), still, np.zeros(0)).elastic[0]
    assert stored == pytest.approx(0.5 * force * deflection, rel=1e-3)


@pytest.mark.parametrize("elements", ["linear", "smoothed"])
@pytest.mark.parametrize("preconditioner", ["factor", "two_level"])
def test_the_same_material_by_region_changes_nothing(elements: Any, preconditioner: Any) -> None:
    """And a whole body of a region's material is one of that material, to rounding."""
    whole = bar(layers=True, cells=(8, 2, 2))
    nodes = np.arange(len(whole.mesh.points), dtype=np.int32)
    every = replace(whole, regions={**whole.regions, "hard": nodes})
    plain = replace(whole, material=material(HARD), materials={})
    places = []
    for body in (every, plain):
        scene = Scene(character=body)
        options = SimulationOptions(
            precision="float64", tolerance=1e-12, elements=elements, preconditioner=preconditioner
        )
        simulation = Simulation(scene, options=options)
        for _ in range(10):
            simulation.step()
        places.append(numbers(simulation.state.positions))
    np.testing.assert_allclose(places[0], places[1], atol=1e-12)


def test_a_dense_half_weighs_more() -> None:
    body = bar(layers=False)
    heavy = replace(body, materials={"hard": material(HARD, density=3.0)})
    assert heavy.node_masses.sum() == pytest.approx(2.0 * body.mesh.volume)
    center = heavy.node_masses @ heavy.mesh.points[:, 0] / heavy.node_masses.sum()
    assert center == pytest.approx((0.25 * 1.0 + 0.75 * 3.0) / 4.0)


def test_files_keep_materials(tmp_path: Path) -> None:
    body = bar(layers=True, cells=(4, 2, 2))
    body.save(tmp_path / "bar.char")
    assert Character.load(tmp_path / "bar.char") == body
    plan = ScenePlan(
        name="own",
        description="a bar",
        scene=Scene(character=body),
        controller=None,
        seconds=1.0,
        time_step=0.01,
        settings={},
    )
    scene_files.write(tmp_path / "own.toml", plan)
    assert scene_files.read(tmp_path / "own.toml").plan.scene == plan.scene
    text = (
        '[character]\nname = "bar"\nshape = "box"\nsize = [1.0, 0.1, 0.1]\n'
        "[character.regions]\nhard = { low = [0.0, -1.0, -1.0] }\n"
        "[character.materials.hard]\nyoung_modulus = 1e6\n"
    )
    (tmp_path / "box.toml").write_text(text)
    found = scene_files.read(tmp_path / "box.toml").plan.scene.character
    assert found.materials["hard"] == Material(young_modulus=1e6)
    assert 0.4 < np.mean(found.tet_materials.stiffness > 1.0) < 0.6


def test_what_cannot_be_mixed_is_refused() -> None:
    body = bar(layers=True, cells=(4, 2, 2))
    with pytest.raises(InputError, match="must have the poisson_ratio, volume and damping"):
        replace(body, materials={"hard": Material(poisson_ratio=0.3)})
    with pytest.raises(InputError, match="has no region 'core'"):
        replace(body, materials={"core": material(HARD)})
    with pytest.raises(InputError, match="'tip' of 'bar': region 'tip' holds no whole tet"):
        replace(body, materials={"tip": material(HARD)})
    muscled = muscular_bar()
    own = replace(muscled.material, young_modulus=1e6)
    whole = np.arange(len(muscled.mesh.points), dtype=np.int32)
    scene = Scene(character=replace(muscled, regions={"all": whole}, materials={"all": own}))
    with pytest.raises(InputError, match="materials by region, which go with implicit muscles"):
        Simulation(scene, options=SimulationOptions(muscles="explicit"))
