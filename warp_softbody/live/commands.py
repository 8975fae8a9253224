"""What a page may ask for: small JSON objects, each checked before anything is done.

A command is `{"do": NAME, ...}`:

    play, pause, step, restart, release
    speed     value    simulated over real time, 0.05 to 4
    control   value    "qpcc", "static" or "none"
    friction  value    Coulomb's coefficient of the ground, 0 to 10
    gravity   value    m/s^2, 0 to 100
    steer     forward, aside, turning   shares, -1 to 1, of what the feet can do
    push      share    of the weight, 0 to 2;  degrees  about the ground's normal, from its x axis
    grab      point    row of the shown points;  to  (x, y, z) m
    drag      to       (x, y, z) m
    record    value    true or false
"""

from __future__ import annotations

import json
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from typing import Any

from warp_softbody.errors import InputError
from warp_softbody.inputs import checks

MOST_BYTES = 4096
"""Of a command; the longest one that a page sends has about a hundred."""
METHODS = ("qpcc", "static", "none")
FAR = 1e6
"""m, how far away a hand may be."""

Check = Callable[[str, object], Any]


def _number(low: float, high: float, unit: str = "") -> Check:
    return lambda label, value: checks.number(label, value, low=low, high=high, unit=unit)


def _place(label: str, value: object) -> tuple[float, ...]:
    place = checks.vector(label, value, unit="m")
    if max(map(abs, place)) > FAR:
        raise InputError(f"{label} must be within {FAR:g} m")
    return place


def _method(label: str, value: object) -> str:
    return checks.choice(label, value, METHODS)


FIELDS: Mapping[str, Mapping[str, Check]] = {
    "play": {},
    "pause": {},
    "step": {},
    "restart": {},
    "release": {},
    "speed": {"value": _number(0.05, 4.0)},
    "control": {"value": _method},
    "friction": {"value": _number(0.0, 10.0)},
    "gravity": {"value": _number(0.0, 100.0, "m/s^2")},
    "steer": {name: _number(-1.0, 1.0) for name in ("forward", "aside", "turning")},
    "push": {"share": _number(0.0, 2.0), "degrees": _number(-360.0, 360.0)},
    "grab": {"point": lambda label, value: checks.whole(label, value), "to": _place},
    "drag": {"to": _place},
    "record": {"value": checks.truth},
}
"""The fields of each command, and what they must be."""


@dataclass(frozen=True)
class Command:
    """A command that was checked.

    Attributes:
        do: its name.
        given: its fields.
    """

    do: str
    given: Mapping[str, Any] = field(default_factory=dict)


def read_command(contents: bytes) -> Command:
    """The command that a message stands for.

    Raises:
        InputError: it is too long, no JSON, or no command.
    """
    if len(contents) > MOST_BYTES:
        raise InputError(f"a command has at most {MOST_BYTES} bytes, not {len(contents)}")
    try:
        told = json.loads(contents.decode("utf-8"))
    except (ValueError, RecursionError):
        raise InputError("a command must be JSON in UTF-8") from None
    if not isinstance(told, dict):
        raise InputError("a command must be a JSON object")
    name = told.pop("do", None)
    if not isinstance(name, str) or name not in FIELDS:
        raise InputError(f"there is no command {checks.shown(name)}; there are {', '.join(FIELDS)}")
    wanted = FIELDS[name]
    if set(told) != set(wanted):
        fields = ", ".join(wanted) or "none"
        raise InputError(f"command {name!r} has these fields: {fields}")
    given = {key: check(f"{key} of {name!r}", told[key]) for key, check in wanted.items()}
    return Command(name, given)
