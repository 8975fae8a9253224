"""Stiff and soft cubes that slide: friction takes mu g dt a step, and no floor drives a body."""

from __future__ import annotations

import numpy as np
import pytest

from tests.support.bodies import box
from tests.verification.conservation.flight import GRAVITY, PRECISIONS
from warp_softbody import (
    Character,
    Frame,
    Material,
    Plane,
    Scene,
    Simulation,
    SimulationOptions,
    placed,
)
from warp_softbody.engine.options import Cone, Precision
from warp_softbody.scenes import make

DT = 1.0 / 120.0


def slide(
    young_modulus: float,
    cells: int,
    *,
    speed: float = 6.0,
    friction: float = 0.5,
    precision: Precision = "auto",
    time_step: float = DT,
    cone: Cone = "smooth",
    passes: int = 80,
) -> Simulation:
    """A cube of 0.1 m on the ground, at a speed along x."""
    material = Material(young_modulus=young_modulus, poisson_ratio=0.3)
    body = Character(name="cube", mesh=box((cells,) * 3, (0.1, 0.1, 0.1)), material=material)
    scene = Scene(
        character=body, ground=Plane(friction=friction), initial_velocity=(speed, 0.0, 0.0)
    )
    options = SimulationOptions(
        precision=precision, time_step=time_step, cone=cone, max_contact_passes=passes
    )
    return Simulation(scene, options=options, fps=1.0 / time_step)


def speed_of(simulation: Simulation, frame: Frame) -> float:
    """Of the centre of mass along x, m/s."""
    masses = simulation.model.masses
    return float((masses @ frame.velocities / masses.sum())[0])


@pytest.mark.parametrize("precision", PRECISIONS)
@pytest.mark.parametrize(
    ("young_modulus", "cells"),
    [(1e6, 4), (1e7, 7), (1e8, 4), (1e8, 5), (1e8, 7), (1e8, 8), (1e8, 9), (1e9, 4), (1e10, 5)],
)
def test_the_first_step_of_a_slide(young_modulus: float, cells: int, precision: Precision) -> None:
    """It loses mu g dt, to friction of half the weight; the modes of no node are known before."""
    simulation = slide(young_modulus, cells, precision=precision)
    *_, frame = simulation.run(DT)
    lost = (6.0 - speed_of(simulation, frame)) / (0.5 * GRAVITY * DT)
    weight = simulation.model.masses.sum() * GRAVITY
    force = frame.contacts.forces.sum(axis=0) / weight
    assert lost == pytest.approx(1.0, abs=0.05)
    assert force[2] == pytest.approx(1.0, abs=0.05)
    assert force[0] == pytest.approx(-0.5, abs=0.05)


@pytest.mark.parametrize("precision", PRECISIONS)
@pytest.mark.parametrize("cells", [4, 8])
def test_a_slide_stops_where_it_should(cells: int, precision: Precision) -> None:
    """After v^2 / (2 mu g) and half a step of the speed less, since x+ = x + dt v+."""
    simulation = slide(1e7, cells, precision=precision)
    largest, before = 0.0, 6.0
    for frame in simulation.run(1.5):
        speed = speed_of(simulation, frame)
        if speed > 0.1 and frame.index:
            largest = max(largest, (before - speed) / (0.5 * GRAVITY * DT))
        before = speed
    masses = simulation.model.masses
    rest = simulation.model.body.mesh.points
    way = float((masses @ (frame.positions - rest) / masses.sum())[0])
    assert way == pytest.approx(6.0**2 / (2.0 * 0.5 * GRAVITY) - 6.0 * DT / 2.0, rel=2e-3)
    assert largest < 1.1 and abs(speed) < 1e-4
    if precision == "float64":
        assert simulation.summary().findings.doubts == ()


@pytest.mark.parametrize("young_modulus", [1e5, 1e6, 1e7, 1e8, 1e9])
def test_a_frictionless_floor_drives_nothing(young_modulus: float) -> None:
    """The shipped scene at its public settings: 1 m/s after two seconds, at any stiffness."""
    settings = {"young_modulus": young_modulus, "friction": 0.0, "speed": 1.0}
    plan = make("drop-block", settings)
    simulation = Simulation(plan.scene, time_step=plan.time_step)
    *_, frame = simulation.run(2.0)
    assert speed_of(simulation, frame) == pytest.approx(1.0, abs=1e-5)


@pytest.mark.parametrize("seed", range(12))
def test_slides_of_any_kind(seed: int) -> None:
    """Cubes that are stiff enough to slide as a whole lose mu g t, whatever step and speed."""
    rng = np.random.default_rng(seed)
    friction, speed = float(rng.uniform(0.05, 0.6)), 10.0 ** rng.uniform(0.0, 2.0)
    simulation = slide(
        10.0 ** rng.uniform(6.0, 10.0),
        int(rng.integers(2, 6)),
        speed=speed,
        friction=friction,
        time_step=10.0 ** rng.uniform(-4.0, -1.5),
        cone=str(rng.choice(["smooth", "8"])),  # type: ignore[arg-type]
    )
    dt = simulation.model.options.time_step
    seconds = min(20 * dt, 0.8 * speed / (friction * GRAVITY))
    *_, frame = simulation.run(seconds)
    lost = speed - speed_of(simulation, frame)
    assert lost == pytest.approx(friction * GRAVITY * frame.time, rel=0.01)


@pytest.mark.parametrize("cone", ["smooth", "8", "4"])
@pytest.mark.parametrize("passes", [1, 2, 3, 6, 15])
def test_a_step_that_does_not_settle_is_safe(passes: int, cone: Cone) -> None:
    """Few passes: no impulse pulls or leaves its cone by much, none drives, and it is told."""
    simulation = slide(1e8, 7, precision="float64", cone=cone, passes=passes)
    weight = simulation.model.masses.sum() * GRAVITY
    energy = 0.5 * simulation.model.masses.sum() * 36.0
    for frame in simulation.run(10 * DT):
        forces = frame.contacts.forces
        velocities = frame.velocities[frame.contacts.nodes]
        assert (forces[:, :2] * velocities[:, :2]).sum(axis=1).max(initial=0.0) < 1e-6 * weight
        kinetic = 0.5 * simulation.model.masses @ (frame.velocities**2).sum(axis=1)
        # nodes that sank are pushed out again
        assert kinetic <= energy * (1.0 + 1e-4)
    summary = simulation.summary()
    assert summary.findings.contact_gain < 1e-6 * energy
    if summary.unconverged_steps:
        worst = summary.findings.unsettled
        assert worst is not None and worst.body == "cube" and worst.force >= 0.0


@pytest.mark.parametrize("young_modulus", [1e8, 1e10, 1e12])
def test_a_stiff_block_lands_and_keeps_its_shape(young_modulus: float) -> None:
    """It falls on an edge: a solve that an old factor serves badly goes on with a new one."""
    mesh = box((4, 2, 2), (0.4, 0.2, 0.2))
    body = Character(name="block", mesh=mesh, material=Material(young_modulus=young_modulus))
    tilted = placed(body, translation=(0.0, 0.0, 0.3), axis=(1.0, 0.2, 0.0), degrees=20.0)
    options = SimulationOptions(precision="float64")
    simulation = Simulation(Scene(character=tilted, ground=Plane()), options=options)
    *_, frame = simulation.run(2.0)
    findings = simulation.summary().findings
    least, largest = findings.volumes
    # a turning body swells by a step's first order
    assert 0.999 < least <= largest < 1.02
    assert np.abs(frame.velocities).max() < 1e-3 and findings.depth < 1e-5
