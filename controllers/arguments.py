"""Controllers remember what they were made with, so that one can be written down or made anew."""

from __future__ import annotations

import inspect
from collections.abc import Mapping
from functools import wraps
from types import MappingProxyType
from typing import Any, TypeVar

Kind = TypeVar("Kind", bound=type[Any])

_KEPT = "_made_with"


def remembered(kind: Kind) -> Kind:
    """Let the objects of a class keep the arguments of their constructor; a decorator."""
    make = kind.__init__
    signature = inspect.signature(make)

    @wraps(make)
    def __init__(self: Any, *args: Any, **named: Any) -> None:
        make(self, *args, **named)
        bound = signature.bind(self, *args, **named)
        bound.apply_defaults()
        given = dict(bound.arguments)
        given.pop(next(iter(signature.parameters)))
        # of the class itself, not of one that adds to it and calls this
        if _KEPT not in vars(self):
            setattr(self, _KEPT, given)

    kind.__init__ = __init__
    return kind


def arguments_of(controller: object) -> Mapping[str, Any] | None:
    """The arguments that a controller was made with, by name; None where it keeps none."""
    given = vars(controller).get(_KEPT) if hasattr(controller, "__dict__") else None
    return None if given is None else MappingProxyType(given)
