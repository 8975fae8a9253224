"""Tables of all options for docs/command-line.md, made from the option classes' fields.

``python -m benchmarks.option_tables --write docs/command-line.md`` brings the page up to date;
without ``--write`` the tables go to standard output.
"""

from __future__ import annotations

import argparse
import sys
from collections.abc import Sequence
from pathlib import Path
from typing import Any

from benchmarks.marked_page import put, rows
from warp_softbody.cli.option_flags import default_of
from warp_softbody.cli.run_command import OWN_DEFAULTS
from warp_softbody.controllers.control_options import ControlOptions
from warp_softbody.engine.options import SimulationOptions
from warp_softbody.inputs.option_fields import Option, options_of
from warp_softbody.inputs.option_kinds import ChoiceKind, TruthKind

CLASSES = (SimulationOptions, ControlOptions)
BEGIN, END = "<!-- options of {}: begin -->", "<!-- options of {}: end -->"


def table(owner: type[Any]) -> str:
    """The options of a class as a Markdown table, a row each."""
    return rows([["option", "default", "values", "meaning"], *(row(o) for o in options_of(owner))])


def row(one: Option) -> list[str]:
    """The cells of an option."""
    name = f"`{one.flag_name}`" if one.flag else f"`{one.name}`"
    values = one.kind.range
    if isinstance(one.kind, ChoiceKind):
        values = ", ".join(f"`{value}`" for value in one.kind.known)
    elif isinstance(one.kind, TruthKind):
        name = f"{name}, `{one.flag_name.replace('--', '--no-')}`"
    unit = f" {one.unit}" if one.unit else ""
    default = default_of(one) if one.default is None else f"{default_of(one)}{unit}"
    if one.name in OWN_DEFAULTS:
        default = f"{OWN_DEFAULTS[one.name]}; in Python {default}"
    return [name, default, f"{values}{unit}", one.help]


def main(arguments: Sequence[str] | None = None) -> int:
    """Write or print the tables; 0."""
    parser = argparse.ArgumentParser(prog="python -m benchmarks.option_tables", description=__doc__)
    parser.add_argument("--write", type=Path, help="page between whose marks the tables go")
    page = parser.parse_args(arguments).write
    for owner in CLASSES:
        if page is None:
            print(f"{owner.__name__}\n\n{table(owner)}\n")
        else:
            begin, end = (mark.format(owner.__name__) for mark in (BEGIN, END))
            put(page, begin, end, table(owner))
    return 0


if __name__ == "__main__":
    sys.exit(main())
