"""What a controlled body remembers from step to step, kept so that it can be taken up again."""

from __future__ import annotations

import copy
from dataclasses import dataclass
from typing import Any

from warp_softbody.controllers.control_solver import SolverMemory
from warp_softbody.controllers.controller import Controller
from warp_softbody.engine.block_solver import SavedResponses
from warp_softbody.errors import InputError


@dataclass(frozen=True, eq=False, repr=False)
class SavedControl:
    """A controlled body between two steps.

    Attributes:
        name: of the body.
        kind: class of its controller.
        ahead: time steps that its plans look ahead.
        memory: attributes of the controller, copied.
        solver: what the control solver remembers.
        responses: where the next solve for the reduced dynamics begins.
    """

    name: str
    kind: type[Any]
    ahead: int
    memory: dict[str, Any]
    solver: SolverMemory
    responses: SavedResponses


def memory_of(controller: Controller) -> dict[str, Any]:
    """A copy of all that a controller remembers, which is in its attributes.

    Raises:
        InputError: it keeps none, or what cannot be copied.
    """
    kind = type(controller).__name__
    if not hasattr(controller, "__dict__") or _slots(type(controller)):
        raise InputError(f"save: a {kind} has slots, so that what it remembers cannot be kept")
    try:
        return copy.deepcopy(vars(controller))
    except Exception as error:
        raise InputError(f"save: what a {kind} remembers cannot be copied: {error}") from error


def remind(controller: Controller, memory: dict[str, Any]) -> None:
    """Let a controller remember what one of its class once did, and nothing else."""
    own = vars(controller)
    own.clear()
    own.update(copy.deepcopy(memory))


def _slots(kind: type[Any]) -> bool:
    return any(vars(base).get("__slots__") for base in kind.__mro__)
