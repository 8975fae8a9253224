"""The shipped gains of a scene where they were not searched.

    python -m benchmarks.search_gains_variants jump-i

Runs the scene as it is, with friction, Young's modulus and muscle strength 20 % down and up, and
with half the time step, and prints the measures of its goals; a star marks a goal that is missed.
"""

from __future__ import annotations

import argparse
import sys
from collections.abc import Iterator, Mapping, Sequence
from typing import NamedTuple

from benchmarks.search_gains import missing, run
from benchmarks.search_gains_cases import CASES, Case
from warp_softbody import scenes

SHARE = 0.2


class Variant(NamedTuple):
    """One way in which a run differs from the shipped one."""

    name: str
    changes: Mapping[str, float]
    settings: Mapping[str, float]
    time_step: float | None


def variants(case: Case) -> Iterator[Variant]:
    """The shipped scene first."""
    plan = scenes.make(case.scene, case.settings)
    character = plan.scene.character
    yield Variant("as shipped", {}, {}, None)
    for sign in (-SHARE, SHARE):
        friction = plan.settings["friction"] * (1.0 + sign)
        yield Variant(f"friction {sign:+.0%}", {}, {"friction": friction}, None)
    stiffness, strength = character.material.young_modulus, character.muscles[0].strength
    for name, path, value in (
        ("stiffness", "material.young_modulus", stiffness),
        ("strength", "strength", strength),
    ):
        for sign in (-SHARE, SHARE):
            yield Variant(f"{name} {sign:+.0%}", {path: value * (1.0 + sign)}, {}, None)
    yield Variant("half the step", {}, {}, plan.time_step / 2.0)


def main(arguments: Sequence[str] | None = None) -> int:
    """Run every variant and print a line for each."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("scene", choices=sorted(CASES))
    parser.add_argument("--seconds", type=float, help="length of a run; default the scene's")
    args = parser.parse_args(arguments)
    case = CASES[args.scene]
    for variant in variants(case):
        found = run(
            case,
            variant.changes,
            settings=variant.settings,
            time_step=variant.time_step,
            seconds=args.seconds,
        )
        cells = [
            f"{goal.measure} {found[goal.measure]:.3g}{'*' if missing(goal, found, 0.0) else ''}"
            for goal in case.goals
        ]
        ending = f"  fallen after {found['seconds']:.2f} s" if found["fallen"] else ""
        print(f"{variant.name:15} {'  '.join(cells)}{ending}", flush=True)
    return 0


if __name__ == "__main__":
    sys.exit(main())
