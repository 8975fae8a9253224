"""The flags of the command line are made from the fields of option classes."""

from __future__ import annotations

import argparse
from collections.abc import Callable, Mapping
from typing import Any

from warp_softbody.errors import InputError
from warp_softbody.inputs.option_fields import Option, options_of
from warp_softbody.inputs.option_kinds import ChoiceKind, TruthKind, WholeKind


def add_option_flags(
    parser: argparse.ArgumentParser,
    owner: type[Any],
    title: str,
    defaults: Mapping[str, str] | None = None,
) -> None:
    """Add a group of flags, one for each option of a class that has one.

    Args:
        parser: what they are added to.
        owner: the option class.
        title: of the group in the help.
        defaults: by the option's name, what the help says of a default that is not the class's.
    """
    group = parser.add_argument_group(title)
    for one in options_of(owner):
        if one.flag:
            told = (defaults or {}).get(one.name, default_of(one))
            _add(group, one, f"{one.help} ({told})".replace("%", "%%"))


def _add(group: Any, one: Option, text: str) -> None:
    if isinstance(one.kind, TruthKind):
        action = argparse.BooleanOptionalAction
        group.add_argument(one.flag_name, action=action, default=None, help=text)
    elif isinstance(one.kind, ChoiceKind):
        known = one.kind.known
        group.add_argument(one.flag_name, type=one.kind.read, choices=known, help=text)
    else:
        metavar = "N" if isinstance(one.kind, WholeKind) else one.unit.upper() or "X"
        group.add_argument(one.flag_name, type=_reader(one), metavar=metavar, help=text)


def _reader(one: Option) -> Callable[[str], Any]:
    """A reader of a flag's text; argparse puts the flag's name before the sentence."""

    def read(text: str) -> Any:
        try:
            return one.check(one.kind.read(text), label="")
        except InputError as error:
            raise argparse.ArgumentTypeError(str(error).strip()) from error

    return read


def default_of(one: Option) -> str:
    """What an option is where it is not given, in words."""
    if one.default is None:
        return str(one.unset)
    if isinstance(one.default, bool):
        return "on" if one.default else "off"
    return f"{one.default:.4g}" if isinstance(one.default, float) else str(one.default)


def given_options(args: argparse.Namespace, owner: type[Any]) -> dict[str, Any]:
    """The options of a class that a command line gave, by name."""
    names = [one.name for one in options_of(owner) if one.flag]
    return {name: getattr(args, name) for name in names if getattr(args, name) is not None}
