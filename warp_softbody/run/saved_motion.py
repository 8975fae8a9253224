"""A simulation's motion, kept so that it can go on from there again, to the last bit."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, fields
from typing import Any

import warp as wp

from warp_softbody.arrays import FloatArray
from warp_softbody.controllers.control_solver import Decision
from warp_softbody.device.array_copies import Copies
from warp_softbody.engine.state import Contacts, Control, State
from warp_softbody.engine.stepper import Stepper
from warp_softbody.errors import InputError
from warp_softbody.run.controlled_body import ControlledBody
from warp_softbody.run.saved_control import SavedControl
from warp_softbody.world.scene import Scene

OTHER_SCENE = "a SavedMotion can be restored by a simulation of the same scene alone"


@dataclass(frozen=True, eq=False, repr=False)
class SavedMotion:
    """What `Simulation.save` returns and `Simulation.restore` takes, of one model.

    Attributes:
        scene: that moves.
        time_step: s, of the steps.
        steps: taken so far.
        arrays: all that changes from step to step, in a fixed order.
        rest_lengths: (s,) m, of the muscles.
        driven: whether activations are held.
        still: steps for which all has been still.
        acting: whether forces acted in the last step.
        aside: (k, 3) m of each handle, where its nodes are from its path.
        handle_forces: (3,) N of each handle in the last step.
        age: of what the preconditioner keeps.
        fresh: iterations of a pass that a fresh one would need.
        controls: what each controlled body remembers.
        decision: of the last step; None where no controller decided in it.
    """

    scene: Scene
    time_step: float
    steps: int
    arrays: Copies
    rest_lengths: FloatArray
    driven: bool
    still: int
    acting: bool
    aside: tuple[FloatArray, ...]
    handle_forces: tuple[FloatArray, ...]
    age: float
    fresh: float
    controls: tuple[SavedControl, ...]
    decision: Decision | None


def require_same_scene(saved: SavedMotion, scene: Scene, time_step: float) -> None:
    """Refuse a motion of anything else than a scene, in steps of a length, s.

    Raises:
        InputError: it is of another scene, or in other time steps.
    """
    if saved.time_step != time_step:
        raise InputError(
            f"a SavedMotion in time steps of {saved.time_step:g} s cannot be restored by a "
            f"simulation in steps of {time_step:g} s"
        )
    if saved.scene is not scene and saved.scene != scene:
        raise InputError(OTHER_SCENE)


def require_same_controllers(saved: SavedMotion, bodies: tuple[ControlledBody, ...]) -> None:
    """Refuse a motion under controllers of other bodies or classes than those given.

    Raises:
        InputError: it is one.
    """
    if len(saved.controls) != len(bodies):
        raise InputError(
            f"a SavedMotion with {len(saved.controls)} controlled bodies cannot be restored by a "
            f"simulation with {len(bodies)}"
        )
    for body, control in zip(bodies, saved.controls, strict=True):
        body.require_fit(control)


def arrays_of(
    state: State, control: Control, contacts: Contacts, stepper: Stepper
) -> Iterator[Any]:
    """The device arrays that change from step to step, and matter to the next one."""
    for part in (state, control, contacts, contacts.pairs):
        if part is not None:
            values = (getattr(part, entry.name) for entry in fields(part))
            yield from (value for value in values if isinstance(value, wp.array))
    yield from stepper.contact.kept
