"""Options whose fields say what they are.

An option class is a frozen dataclass each of whose fields has metadata made by `option`. Checks,
flags of the command line, knobs of charts, what a run records of itself and the tables of the
documentation are made from these fields (`options_of`): each option is described in one place.
"""

from __future__ import annotations

import textwrap
from dataclasses import dataclass, fields
from typing import Any, TypeVar

from warp_softbody.inputs import checks
from warp_softbody.inputs.option_kinds import NumberKind, OptionKind

KEY = "option"
"""Of a field's metadata."""

WIDTH = 100
"""Columns of a docstring."""

OptionClass = TypeVar("OptionClass")


@dataclass(frozen=True, kw_only=True)
class Option:
    """What a field of an option class is.

    Attributes:
        owner: name of the class.
        name: of the field.
        default: its value where nothing is given.
        kind: which values it takes.
        help: one phrase that says what it does.
        unset: what None stands for; None where None is no value of it.
        flag: whether the command line has it as a flag and a run's record under its name.
        moves: whether the motion depends on it, be it by rounding alone.
        knob: its name among the knobs of charts; None where charts do not vary it.
        short: its name in what charts tell of their points; "" where the value speaks for itself.
    """

    owner: str
    name: str
    default: Any
    kind: OptionKind
    help: str
    unset: str | None = None
    flag: bool = True
    moves: bool = True
    knob: str | None = None
    short: str | None = None

    @property
    def unit(self) -> str:
        """SI unit of a number; "" for what has none."""
        return self.kind.unit if isinstance(self.kind, NumberKind) else ""

    @property
    def flag_name(self) -> str:
        """As the command line spells it."""
        return "--" + self.name.replace("_", "-")

    def check(self, value: object, label: str | None = None) -> Any:
        """The value in its plain type.

        Raises:
            InputError: it is no value of this option; the sentence begins with ``label``, by
                default the names of class and field.
        """
        if value is None and self.unset is not None:
            return None
        return self.kind.check(f"{self.owner}.{self.name}" if label is None else label, value)


def option(kind: OptionKind, text: str, **more: Any) -> dict[str, Any]:
    """The metadata of a field that is an option: attributes of `Option`, ``text`` its help."""
    return {KEY: {"kind": kind, "help": text, **more}}


def options_of(owner: type[Any]) -> tuple[Option, ...]:
    """The options of a class, in the order of its fields."""
    return tuple(
        Option(owner=owner.__name__, name=one.name, default=one.default, **one.metadata[KEY])
        for one in fields(owner)
    )


def described(owner: type[OptionClass]) -> type[OptionClass]:
    """Add to the docstring of an option class what its fields say of themselves."""
    lines = [owner.__doc__ or "", "", "Attributes:"]
    for one in options_of(owner):
        unit = f" {one.unit}" if one.unit else ""
        unset = f" None: {one.unset}." if one.unset is not None else ""
        text = f"{one.name}: {one.help}.{unset} Values: {one.kind.range}{unit}."
        lines += textwrap.wrap(text, WIDTH, initial_indent="    ", subsequent_indent=" " * 8)
    owner.__doc__ = "\n".join(lines)
    return owner


def check_options(record: object) -> None:
    """Check every field of an object of an option class and keep the plain values.

    Raises:
        InputError: a field has a value that it does not take.
    """
    for one in options_of(type(record)):
        checks.keep(record, **{one.name: one.check(getattr(record, one.name))})


def recorded(record: object, *, motion_only: bool = False) -> dict[str, Any]:
    """The values of an option object that a run tells of itself, by name.

    ``motion_only`` leaves out what the motion does not depend on.
    """
    return {
        one.name: getattr(record, one.name)
        for one in options_of(type(record))
        if one.flag and (one.moves or not motion_only)
    }
