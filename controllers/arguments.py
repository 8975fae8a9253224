"""Controllers remember what they were made with, so that one can be written down or made anew."""

from __future__ import annotations

import inspect
from collections.abc import Mapping
from functools import wraps
from types import MappingProxyType
from typing import Any, TypeVar

Kind = TypeVar("Kind", bound=type[Any])

_KEPT = "_made_with"
_SUITED = "_made_for"


def remembered(kind: Kind) -> Kind:
    """Let the objects of a class keep the arguments of their constructor; a decorator.

    What its class method ``for_`` makes keeps those too, but for the body, whatever class it is of.
    """
    if isinstance(vars(kind).get("for_"), classmethod):
        _remember_suited(kind)
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


def _remember_suited(kind: type[Any]) -> None:
    make = vars(kind)["for_"].__func__
    signature = inspect.signature(make)

    @wraps(make)
    def for_(*args: Any, **named: Any) -> Any:
        made = make(*args, **named)
        bound = signature.bind(*args, **named)
        bound.apply_defaults()
        # after the class and the body
        rest = list(bound.arguments)[2:]
        setattr(made, _SUITED, (kind, {name: bound.arguments[name] for name in rest}))
        return made

    kind.for_ = classmethod(for_)


def suited_by(controller: object) -> tuple[type[Any], Mapping[str, Any]] | None:
    """The class whose ``for_`` made a controller, and the arguments; None for what none made."""
    found = vars(controller).get(_SUITED) if hasattr(controller, "__dict__") else None
    return None if found is None else (found[0], MappingProxyType(found[1]))


def arguments_of(controller: object) -> Mapping[str, Any] | None:
    """The arguments that a controller was made with, by name; None where it keeps none."""
    given = vars(controller).get(_KEPT) if hasattr(controller, "__dict__") else None
    return None if given is None else MappingProxyType(given)
