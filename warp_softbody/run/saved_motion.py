"""A simulation's motion, kept so that it can go on from there again, to the last bit."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, fields
from typing import Any

import numpy as np
import numpy.typing as npt
import warp as wp

from warp_softbody.arrays import FloatArray
from warp_softbody.engine.state import Contacts, Control, State
from warp_softbody.engine.stepper import Stepper
from warp_softbody.errors import InputError
from warp_softbody.world.scene import Scene


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
        age: of what the preconditioner keeps.
    """

    scene: Scene
    time_step: float
    steps: int
    arrays: tuple[npt.NDArray[Any], ...]
    rest_lengths: FloatArray
    driven: bool
    still: int
    acting: bool
    aside: tuple[FloatArray, ...]
    age: float


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
        raise InputError("a SavedMotion can be restored by a simulation of the same scene alone")


def arrays_of(
    state: State, control: Control, contacts: Contacts, stepper: Stepper
) -> Iterator[Any]:
    """The device arrays that change from step to step, and matter to the next one."""
    for part in (state, control, contacts, contacts.pairs):
        if part is not None:
            values = (getattr(part, entry.name) for entry in fields(part))
            yield from (value for value in values if isinstance(value, wp.array))
    yield from stepper.contact.preconditioner.kept


def copied(arrays: Iterator[Any]) -> tuple[npt.NDArray[Any], ...]:
    """What device arrays hold now."""
    return tuple(np.array(array.numpy()) for array in arrays)


def write_back(arrays: Iterator[Any], saved: tuple[npt.NDArray[Any], ...]) -> None:
    """Let device arrays hold what they once held.

    Raises:
        InputError: they are those of another model.
    """
    into = tuple(arrays)
    shapes = [array.numpy().shape for array in into]
    if shapes != [values.shape for values in saved]:
        raise InputError("a SavedMotion can be restored by a simulation of the same scene alone")
    for array, values in zip(into, saved, strict=True):
        array.assign(values)
