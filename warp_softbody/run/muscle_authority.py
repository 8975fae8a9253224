"""Which way, and how hard, each fibre of a character can move it as it stands."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from warp_softbody.arrays import FloatArray
from warp_softbody.body.character import Character
from warp_softbody.contact_mode import ContactMode
from warp_softbody.controllers import objectives
from warp_softbody.controllers.authority import response
from warp_softbody.controllers.control_options import ControlOptions
from warp_softbody.controllers.controller import Goals
from warp_softbody.controllers.motions.any_body import feet_of, require_muscles
from warp_softbody.controllers.motions.body_measures import mean_weights
from warp_softbody.controllers.patches import ground_patches
from warp_softbody.inputs import checks
from warp_softbody.run.simulation import Simulation
from warp_softbody.run.step_record import StepRecord
from warp_softbody.world.ground import Plane
from warp_softbody.world.scene import Scene
from warp_softbody.world.view import BodyView

TIME_STEP = 1.0 / 60.0
"""s, in which a contraction acts."""

FULL = 0.5
"""By which a fibre contracts, over its length at rest."""


@dataclass(frozen=True, kw_only=True)
class Authority:
    """What a full contraction of some muscle does within a step of 1/60 s, its feet stuck.

    Attributes:
        name: of the fibre, or of a group.
        centre_of_mass: (3,) g, acceleration of the centre of mass.
        spin: (3,) rate of the angular momentum about it, over m g L.
        feet: acceleration (3,) g of each foot, by its region, were it free.
    """

    name: str
    centre_of_mass: FloatArray
    spin: FloatArray
    feet: Mapping[str, FloatArray]

    @property
    def strength(self) -> float:
        """g, size of the acceleration of the centre of mass."""
        return float(np.linalg.norm(self.centre_of_mass))


class _Probe:
    """Asks for nothing, of all that is to be known."""

    def __init__(self, feet: tuple[str, ...]) -> None:
        self._feet = feet

    def goals(self, view: BodyView) -> Goals:
        weight = objectives.weight_of(view) * view.time_step
        speed = weight / view.mass
        rows = [
            objectives.linear_momentum(view, np.zeros(3), 0.0),
            objectives.angular_momentum(view, np.zeros(3), 0.0),
        ]
        for foot in self._feet:
            weights = mean_weights(view, (foot,))
            rows.append(objectives.velocity(view, weights, np.zeros(3), 0.0, unit=speed))
        return Goals(objectives=tuple(rows), patches=ground_patches(view, self._feet))


def muscle_authority(character: Character) -> tuple[Authority, ...]:
    """The authority of every fibre of a character that stands on a floor, then of its groups.

    Raises:
        InputError: it has no muscles, or neither feet nor a base.
    """
    checks.instance("character of muscle_authority", character, Character)
    require_muscles("muscle_authority", character)
    feet = tuple(name for name in feet_of(character) if character.region(name).size)
    simulation = Simulation(
        Scene(character=character, ground=Plane()),
        _Probe(feet),
        time_step=TIME_STEP,
        control_options=ControlOptions(horizon=0.0),
    )
    found: list[StepRecord] = []
    simulation.observe(found.append)
    simulation.step()
    decision = found[0].decision
    assert decision is not None
    maps, count = decision.maps, 6 + 3 * len(feet)
    gaps = np.zeros(len(feet))
    stuck = response(maps, count, (ContactMode.STICK,) * len(feet), gaps).by_segment
    free = response(maps, count, (ContactMode.LIFT,) * len(feet), gaps).by_segment
    # rows are in m g dt, m g L dt and g dt; a contraction takes from the activations
    by_segment = -FULL * np.concatenate([stuck[:6], free[6:]])
    told, first = [], 0
    for group in character.muscles:
        total = np.zeros(count)
        for number, fiber in enumerate(group.fibers):
            own = by_segment[:, first : first + fiber.segment_count].sum(axis=1)
            first += fiber.segment_count
            total += own
            told.append(_authority(fiber.name or f"{group.name}_{number}", own, feet))
        told.append(_authority(group.name, total, feet))
    return tuple(told)


def _authority(name: str, values: FloatArray, feet: tuple[str, ...]) -> Authority:
    by_foot = values[6:].reshape(-1, 3)
    return Authority(
        name=name,
        centre_of_mass=values[:3],
        spin=values[3:6],
        feet=dict(zip(feet, by_foot, strict=True)),
    )
