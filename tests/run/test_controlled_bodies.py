"""Several bodies of a scene, each with a controller of its own."""

from __future__ import annotations

import numpy as np
import pytest

from tests.support.bodies import box, muscular_bar, numbers
from warp_softbody import (
    Body,
    Character,
    Plane,
    Push,
    Scene,
    Simulation,
    SimulationOptions,
    placed,
)
from warp_softbody.arrays import FloatArray
from warp_softbody.controllers import Balance
from warp_softbody.errors import InputError
from warp_softbody.scenes.balance_i import GAINS, balancing_letter

FIRST, SECOND = "letter_i", "second"
BASE = 0.5
"""m, of a letter along x; its head is as wide."""


OPTIONS = SimulationOptions(time_step=1.0 / 60.0)


def pair(apart: float, push: float, options: SimulationOptions = OPTIONS) -> Simulation:
    """Two letters whose middles are so far apart, m, their heads pushed towards each other.

    The push is in body weights, for 0.2 s; where it is negative, they are pushed apart.
    """
    letter = balancing_letter(1)
    other = placed(letter, name=SECOND, translation=(apart, 0.0, 0.0), degrees=180.0)
    force = push * float(letter.node_masses.sum()) * 9.81
    pushes = tuple(
        Push(region=region, force=(size, 0.0, 0.0), start=0.2, duration=0.2)
        for region, size in (("head", force), (f"{SECOND}.head", -force))
    )
    scene = Scene(character=letter, others=(Body(character=other),), ground=Plane(), pushes=pushes)
    others = {SECOND: Balance(GAINS)}
    return Simulation(scene, Balance(GAINS), others=others, options=options, fps=60.0)


def heads(simulation: Simulation) -> FloatArray:
    """How far each head is from where it was, (2, 3) m."""
    scene, positions = simulation.model.scene, numbers(simulation.state.positions)
    moved = positions - scene.whole.mesh.points
    regions = ("head", f"{SECOND}.head")
    return np.array([moved[scene.whole.region(name)].mean(axis=0) for name in regions])


def test_two_letters_hold_each_other_s_push() -> None:
    """Heads 6 cm apart are pushed at each other by half a weight; they strike and both stand."""
    simulation = pair(BASE + 0.06, 0.5)
    strongest = 0.0
    for _ in range(300):
        simulation.step()
        force = simulation.frame().contacts.force_on(SECOND, by=FIRST)
        strongest = max(strongest, float(force[0]))
    weight = float(balancing_letter(1).node_masses.sum()) * 9.81
    assert strongest > 0.2 * weight
    assert np.abs(heads(simulation)).max() < 0.02


def test_both_are_controlled_alike() -> None:
    """What is turned by half a turn moves turned by half a turn, and both use their muscles."""
    simulation = pair(2.0, -0.4)
    for _ in range(90):
        simulation.step()
    first, second = simulation.model.scene.parts
    positions = numbers(simulation.state.positions)
    turned = positions[first.nodes] * (-1.0, -1.0, 1.0) + (2.0, 0.0, 0.0)
    np.testing.assert_allclose(positions[second.nodes], turned, atol=1e-4)
    activations = simulation.frame().activations
    for part in (first, second):
        assert activations[part.segments].min() < 0.98


def test_one_far_away_changes_nothing() -> None:
    """Each does what it does alone, to what the solves of a larger system leave: 1e-4 m.

    In single precision that decides between modes of contact which are as good as each other.
    """
    options = SimulationOptions(time_step=1.0 / 60.0, precision="float64")
    together = pair(3.0, 0.3, options)
    scene = together.model.scene
    alone = Scene(character=scene.character, ground=Plane(), pushes=scene.pushes[:1])
    single = Simulation(alone, Balance(GAINS), options=options, fps=60.0)
    count = len(scene.character.mesh.points)
    for _ in range(90):
        together.step()
        single.step()
    found = numbers(together.state.positions)[:count]
    np.testing.assert_allclose(found, numbers(single.state.positions), atol=1e-4)


def test_wrong_bodies_and_controllers_are_refused() -> None:
    bar = muscular_bar()
    ball = Character(name="ball", mesh=box(origin=(2.0, 0.0, 0.0)))
    scene = Scene(character=bar, others=(Body(character=ball),), ground=Plane())
    one = Balance()
    with pytest.raises(InputError, match="no body of the scene is named 'none'; there are: bar"):
        Simulation(scene, others={"none": one})
    with pytest.raises(InputError, match="names 'bar', the scene's character"):
        Simulation(scene, others={"bar": one})
    with pytest.raises(InputError, match="two bodies of a Simulation have one controller"):
        Simulation(scene, one, others={"ball": one})
    with pytest.raises(InputError, match="must be a controller, not the class Balance"):
        Simulation(scene, others={"ball": Balance})  # type: ignore[dict-item]
    with pytest.warns(UserWarning, match="'ball' has no muscles"):
        Simulation(scene, others={"ball": one})
