"""Controllers of a scene file: a kind, the arguments of its constructor, and a table of gains."""

from __future__ import annotations

import inspect
from collections.abc import Mapping
from typing import Any

from warp_softbody import controllers
from warp_softbody.body.character import Character
from warp_softbody.controllers.arguments import arguments_of, suited_by
from warp_softbody.controllers.controller import Controller
from warp_softbody.errors import InputError
from warp_softbody.inputs import checks
from warp_softbody.inputs.records import same
from warp_softbody.scene_files.records import record_of, table_of
from warp_softbody.scene_files.tables import Table

KINDS = (
    "balance",
    "cartwheel",
    "crawl",
    "exercise",
    "flip",
    "gesture",
    "jump",
    "leap",
    "roll",
    "slide",
    "walk",
)
"""Of each there is a class of that name in `controllers`, and one of its gains."""

COMPOSED = ("combined", "sequence")
"""Kinds that are composed of others, each of which is a table."""

ENDS = ("seconds", "distance")
"""Keys of a motion in a sequence, by which it is over."""

PARTS = {"legs": "Leg", "path": "Sway", "steering": "Steering", "take_off": "TakeOff"}
"""Arguments that are records of their own, or several of these."""


def _class_of(kind: str) -> type[Any]:
    found: type[Any] = getattr(controllers, kind.capitalize())
    return found


def controller_of(table: Table, character: Character, also: tuple[str, ...] = ()) -> Controller:
    """The controller of a table, for a character; the keys ``also`` are read elsewhere."""
    kind = table.choice("kind", (*KINDS, *COMPOSED))
    if kind == "sequence":
        return _sequence(table, character, also)
    if kind == "combined":
        return _combined(table, character, also)
    own = _class_of(kind)
    suited = table.take("for_body", False)
    if not isinstance(suited, bool):
        table.fail("must be true or false", "for_body")
    if suited and not hasattr(own, "for_"):
        table.fail(f"a controller of the kind {kind!r} has no gains for any body", "for_body")
    make = own.for_ if suited else own
    names = [name for name in inspect.signature(make).parameters if name != "character"]
    table.only(["kind", "for_body", *names, *also])
    given = {name: _argument(make, name, table) for name in names if name in table}
    with table.explained():
        missing = [
            name
            for name, parameter in inspect.signature(make).parameters.items()
            if name not in ("character", *given) and parameter.default is parameter.empty
        ]
        if missing:
            any_body = "" if suited else "; `for_body = true` suits it to any body without it"
            table.fail(
                f"the key {missing[0]!r} is missing{any_body if hasattr(own, 'for_') else ''}"
            )
        controller: Controller = make(character, **given) if suited else make(**given)
    return controller


def _sequence(table: Table, character: Character, also: tuple[str, ...]) -> Controller:
    """A sequence of the motions that are tables."""
    names = ("rounds", "fade", "ease")
    table.only(["kind", "motions", *names, *also])
    given = table.tables("motions")
    motions = [_motion(own, character) for own in given]
    for own, motion in zip(given[:-1], motions, strict=False):
        if not motion.ends:
            own.fail(
                "never ends, but another motion follows: give it 'seconds' or 'distance'", "kind"
            )
    with table.explained():
        return controllers.Sequence(
            motions, **{name: table.take(name) for name in names if name in table}
        )


def _motion(table: Table, character: Character) -> controllers.Motion:
    own = controller_of(table, character, also=(*ENDS, "name"))
    with table.explained():
        given = {key: table.take(key) for key in (*ENDS, "name") if key in table}
        return controllers.Motion(controller=own, **given)


def _combined(table: Table, character: Character, also: tuple[str, ...]) -> Controller:
    """What the controllers that are tables want together."""
    table.only(["kind", "together", *also])
    given = table.tables("together")
    made = [controller_of(own, character, also=("weight",)) for own in given]
    weights = []
    for own in given:
        with own.explained("weight"):
            weights.append(checks.number("weight", own.take("weight", 1.0), low=0.0))
    with table.explained():
        return controllers.Combined(made, weights=weights)


def _argument(make: Any, name: str, table: Table) -> Any:
    if name == "gains":
        # as in "WalkGains | None"
        hint = str(inspect.signature(make).parameters[name].annotation)
        return record_of(getattr(controllers, hint.split(" ")[0]), table.table(name))
    if name in PARTS:
        part = getattr(controllers, PARTS[name])
        if table.is_table(name):
            own = table.table(name)
            if name == "steering" and "points" in own:
                part = controllers.Trail
            return record_of(part, own)
        return tuple(record_of(part, each) for each in table.tables(name))
    return table.take(name)


def table_of_controller(controller: object) -> dict[str, Any]:
    """What `controller_of` makes an equal controller of.

    Raises:
        InputError: it is none of the package's own.
    """
    if isinstance(controller, controllers.Sequence):
        return _table_of_sequence(controller)
    if isinstance(controller, controllers.Combined):
        weights = ({} if weight == 1.0 else {"weight": weight} for weight in controller.weights)
        members = zip(controller.together, weights, strict=True)
        return {
            "kind": "combined",
            "together": [table_of_controller(own) | weight for own, weight in members],
        }
    suited = suited_by(controller)
    if suited is not None and suited[0] is not type(controller):
        own, given = suited
        found = _changed(given, inspect.signature(own.for_).parameters)
        return {"kind": own.__name__.lower(), "for_body": True, **found}
    kind = type(controller).__name__.lower()
    kept = arguments_of(controller)
    if kind not in KINDS or _class_of(kind) is not type(controller) or kept is None:
        raise InputError(
            f"a controller of the class {type(controller).__name__} cannot be written to a file, "
            f"only {', '.join((*KINDS, *COMPOSED))}"
        )
    return {"kind": kind, **_changed(kept, inspect.signature(type(controller)).parameters)}


def _table_of_sequence(sequence: controllers.Sequence) -> dict[str, Any]:
    kept = dict(arguments_of(sequence) or {})
    del kept["motions"]
    tables = []
    for motion in sequence.motions:
        if motion.until is not None:
            raise InputError(
                f"the motion {motion.title!r} of a sequence ends by a function, which cannot be "
                "written to a file"
            )
        own = {key: getattr(motion, key) for key in (*ENDS, "name")}
        found = {key: value for key, value in own.items() if value is not None}
        tables.append(table_of_controller(motion.controller) | found)
    parameters = inspect.signature(controllers.Sequence).parameters
    return {"kind": "sequence", **_changed(kept, parameters), "motions": tables}


def _changed(given: Mapping[str, Any], known: Mapping[str, inspect.Parameter]) -> dict[str, Any]:
    """The arguments that are not those of their defaults, in plain values."""
    return {
        name: _plain(value)
        for name, value in given.items()
        if value is not None and not same(value, known[name].default)
    }


def _plain(value: Any) -> Any:
    if callable(value):
        raise InputError("a controller that is steered by a function cannot be written to a file")
    if isinstance(value, tuple) and value and hasattr(value[0], "__dataclass_fields__"):
        return [table_of(each) for each in value]
    return table_of(value) if hasattr(value, "__dataclass_fields__") else value
