"""A body that its controller was to keep upright, and that lies at the end."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from warp_softbody import Plane, Scene, Simulation, characters, controllers
from warp_softbody.controllers.motions.flip import FlipPhase
from warp_softbody.run.falls import tilt
from warp_softbody.world.view import BodyView

LETTER = characters.letter_i(coarse=1)
SCENE = Scene(character=LETTER, ground=Plane())


class Rolling:
    """A controller that may turn its body over."""

    def goals(self, view: BodyView) -> None:
        """Leave the muscles slack."""


@pytest.mark.parametrize("angle", [0.0, 0.4, 1.5, 3.0])
def test_the_tilt_is_that_of_the_rotation(angle: float) -> None:
    """A turn about z, then one about a horizontal axis; the body is swollen and elsewhere."""
    random = np.random.default_rng(3)
    rest, masses = random.normal(size=(30, 3)), random.uniform(1.0, 2.0, 30)
    turned = Rotation.from_rotvec(angle * np.array([0.6, 0.8, 0.0])) * Rotation.from_rotvec(
        [0.0, 0.0, 2.0]
    )
    now = 1.1 * turned.apply(rest) + [3.0, -1.0, 2.0]
    assert tilt(rest, now, masses) == pytest.approx(angle, abs=1e-6)


@pytest.mark.parametrize(
    ("controller", "angle", "fallen"),
    [
        (controllers.Balance(), 80.0, True),
        (controllers.Balance(), 40.0, False),
        (Rolling(), 80.0, False),
        (None, 80.0, False),
    ],
)
def test_a_fall_is_a_doubt(
    controller: controllers.Controller | None, angle: float, fallen: bool
) -> None:
    simulation = Simulation(SCENE, controller)
    lying = Rotation.from_euler("x", angle, degrees=True).apply(np.array(LETTER.mesh.points))
    simulation.state.positions.assign(lying - [0.0, 0.0, lying[:, 2].min()])
    summary = simulation.summary()
    assert any("fell: it stood at the start" in each for each in summary.findings.doubts) == fallen
    assert summary.status == ("doubtful" if fallen else "complete")


def lies_in_doubt(simulation: Simulation) -> bool:
    """Whether a letter that is laid on its side now counts as fallen."""
    lying = Rotation.from_euler("x", 80.0, degrees=True).apply(np.array(LETTER.mesh.points))
    simulation.state.positions.assign(lying - [0.0, 0.0, lying[:, 2].min()])
    return any("fell" in each for each in simulation.summary().findings.doubts)


@pytest.mark.parametrize("phase", list(FlipPhase))
@pytest.mark.parametrize("within", [False, True])
def test_who_turns_a_somersault_has_not_fallen(phase: FlipPhase, within: bool) -> None:
    """But who lies before it or after it has, in a sequence too."""
    flip = controllers.Flip(start=20.0)
    controller = controllers.Sequence([flip, controllers.Balance()]) if within else flip
    simulation = Simulation(SCENE, controller, time_step=1.0 / 60.0)
    simulation.step()
    flip.phase = phase
    assert lies_in_doubt(simulation) == (phase not in (FlipPhase.FLY, FlipPhase.ARREST))


def test_a_sequence_looks_at_the_motion_that_is_on() -> None:
    """One that may turn the body over is on, though the last is to keep it upright."""
    turns = controllers.Motion(controller=Rolling(), seconds=0.02)
    simulation = Simulation(
        SCENE, controllers.Sequence([turns, controllers.Balance()]), time_step=1.0 / 60.0
    )
    simulation.step()
    assert not lies_in_doubt(simulation)
    for _ in range(3):
        simulation.step()
    assert lies_in_doubt(simulation)


def test_a_round_body_that_rolls_about_its_own_axis_has_not_fallen() -> None:
    """It turns by 120 degrees and stays as high as it was."""
    simulation = Simulation(SCENE, controllers.Balance())
    body, rest = simulation.model, np.array(LETTER.mesh.points)
    lying = Rotation.from_euler("x", 120.0, degrees=True).apply(rest)
    middle = body.masses @ rest[:, 2] / body.masses.sum() - rest[:, 2].min()
    height = body.masses @ lying[:, 2] / body.masses.sum() - lying[:, 2].min()
    # as high over its lowest node as before, by scaling alone
    simulation.state.positions.assign(lying * (middle / height))
    assert not any("fell" in each for each in simulation.summary().findings.doubts)
