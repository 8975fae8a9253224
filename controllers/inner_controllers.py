"""What controllers say of themselves, and which others they ask in turn."""

from __future__ import annotations

from collections.abc import Iterable, Iterator

from warp_softbody.controllers.controller import Controller
from warp_softbody.inputs import checks


def says(controller: object, attribute: str, *, otherwise: bool = False) -> bool:
    """A truth value that a controller has as an attribute, or what counts without one.

    Raises:
        InputError: it is something else, such as a method that nobody called.
    """
    value = getattr(controller, attribute, otherwise)
    return checks.truth(f"{attribute} of a {type(controller).__name__}", value)


def told_by(controller: Controller) -> Controller:
    """One whose attributes are what a `Sequence` looks at, as far as they tell before a run.

    Raises:
        InputError: ``finished`` is a method, or ``begin`` takes no two views.
    """
    if callable(getattr(controller, "finished", None)):
        says(controller, "finished")
    begin = getattr(controller, "begin", None)
    if begin is not None:
        label = f"begin of a {type(controller).__name__}"
        checks.called_with(label, begin, 2, "a function of two views")
    return controller


def with_inner(controller: Controller) -> Iterator[Controller]:
    """A controller and all within it, as deep as they lie: by its attribute ``controllers``."""
    yield controller
    within = getattr(controller, "controllers", ())
    if isinstance(within, tuple | list):
        for own in within:
            if callable(getattr(own, "goals", None)):
                yield from with_inner(own)


def two_with_one(owners: Iterable[Iterable[Controller]]) -> tuple[int, int] | None:
    """The first two of owners of controllers that have one together, which remembers its steps.

    One that an owner has twice does not count: a `Sequence` takes copies of it.
    """
    known: dict[int, tuple[int, Controller]] = {}
    for number, given in enumerate(owners):
        for outer in given:
            for own in with_inner(outer):
                # kept beside its number, so that no other can come to have its id
                other, _ = known.setdefault(id(own), (number, own))
                if other != number:
                    return other, number
    return None
