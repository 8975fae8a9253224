"""Whether the tuned settings of motions hold on runs that they were not tuned on.

    python -m benchmarks.tuned_motions                       # every stored motion, every variation
    python -m benchmarks.tuned_motions walk-x --variations "turned world"
    python -m benchmarks.tuned_motions --journal out/tuned.jsonl --write docs/frontier.md

Settings were tuned on a run of the scene as it ships, and on other floors. Here the whole scene is
run with them, on those floors, with softer and firmer bodies and in a turned world, and as it ships
beside it. They hold where the motion meets all its criteria and its own number is as far from that
of what ships as the bound allows.
"""

from __future__ import annotations

import argparse
from collections.abc import Mapping, Sequence
from dataclasses import replace
from pathlib import Path

from benchmarks.beam.arguments import count
from benchmarks.fidelity.variants import TURN
from benchmarks.marked_page import put, rows
from benchmarks.motions.criteria import CRITERIA
from benchmarks.robustness.outcomes import Cell, OutcomeJournal, VariationOutcome
from benchmarks.robustness.sweep import fill
from benchmarks.robustness.variation import Variation
from warp_softbody import scenes
from warp_softbody.accuracy.analysis.store import SHIPPED, load
from warp_softbody.accuracy.analysis.tuning import Tuned
from warp_softbody.controllers.control_options import ControlOptions
from warp_softbody.engine.options import SimulationOptions

BEGIN = "<!-- tuned motions: written by python -m benchmarks.tuned_motions, from here -->"
END = "<!-- tuned motions: to here -->"

UNSEEN = {
    variation.name: variation
    for variation in (
        Variation(name="the whole run"),
        Variation(name="friction -20 %", friction=0.8),
        Variation(name="friction +20 %", friction=1.2),
        Variation(name="stiffness -20 %", stiffness=0.8),
        Variation(name="stiffness +20 %", stiffness=1.2),
        Variation(name="turned world", turn=TURN),
    )
}

Outcomes = Mapping[tuple[str, str], VariationOutcome]


def stored() -> dict[str, Tuned]:
    """The settings of every motion that ship, those of the least bound."""
    found: dict[str, Tuned] = {}
    for tuned in load(SHIPPED):
        known = found.get(tuned.scene)
        if tuned.scene in CRITERIA and (known is None or tuned.bound < known.bound):
            found[tuned.scene] = tuned
    return found


def with_settings(variation: Variation, tuned: Tuned) -> Variation:
    """The variation, run with tuned settings."""
    settings, plan = tuned.settings, scenes.make(tuned.scene)
    options = settings.chosen(SimulationOptions)
    step = options.pop("time_step") / plan.time_step
    return replace(
        variation,
        name=f"{variation.name}, tuned",
        time_step=step,
        levels=settings.refinements,
        settings=settings.of_scene(tuned.scene),
        options=options,
        control=settings.chosen(ControlOptions),
    )


def apart(tuned: VariationOutcome, shipped: VariationOutcome) -> float:
    """How far a motion's own number is from the shipped one's.

    As a share of that. Of a number that is to be small, as an error is, how much more there is of
    it, as a share of its bound: settings that err less than what ships may be the tuned ones.
    """
    own = CRITERIA[tuned.scene][0]
    if not (tuned.values and shipped.values):
        return float("inf")
    more = tuned.values[own.name] - shipped.values[own.name]
    return abs(more / shipped.values[own.name]) if own.at_least else max(0.0, more) / own.bound


def cells(found: Mapping[str, Tuned], variations: Sequence[str]) -> list[Cell]:
    """Both runs of every variation."""
    return [
        Cell(scene=scene, variation=one)
        for scene, tuned in found.items()
        for name in variations
        for one in (UNSEEN[name], with_settings(UNSEEN[name], tuned))
    ]


def markdown(outcomes: Outcomes, found: Mapping[str, Tuned], variations: Sequence[str]) -> str:
    """A line a motion: the number as it ships and tuned, in bold what does not hold."""
    table = [["scene", "bound", *variations]]
    held = made = 0
    for scene, tuned in found.items():
        line = []
        for name in variations:
            shipped = outcomes.get((scene, name))
            other = outcomes.get((scene, f"{name}, tuned"))
            if shipped is None or other is None:
                line.append("not run")
                continue
            made += 1
            text = f"{shipped.own}, {other}"
            far = apart(other, shipped) > tuned.bound
            held += other.holds and not far
            line.append(f"**{text}**" if far and other.holds else text)
        table.append([f"`{scene}`", f"{100.0 * tuned.bound:g} %", *line])
    return f"{rows(table)}\n\n{held} of {made} hold."


def show(outcome: VariationOutcome, _done: int, _total: int) -> None:
    """Print a run."""
    print(f"{outcome.scene:17} {outcome.variation:24} {outcome}", flush=True)


def main(arguments: Sequence[str] | None = None) -> None:
    """Make the runs that the journal lacks, print the table, write it into the page."""
    parser = argparse.ArgumentParser(
        prog="python -m benchmarks.tuned_motions",
        description=__doc__,
        formatter_class=argparse.RawDescriptionHelpFormatter,
    )
    parser.add_argument("scenes", nargs="*", metavar="SCENE", help="names; default all stored")
    parser.add_argument("--variations", nargs="+", choices=UNSEEN, default=list(UNSEEN))
    parser.add_argument("--workers", type=count, default=1, help="processes (1)")
    parser.add_argument("--journal", type=Path, help="file of finished runs")
    parser.add_argument("--write", type=Path, help="page between whose marks the table goes")
    args = parser.parse_args(arguments)
    found = stored()
    if unknown := [name for name in args.scenes if name not in found]:
        known = ", ".join(found) or "none"
        parser.error(f"no stored settings of a motion {unknown[0]!r}; stored: {known}")
    chosen = {scene: found[scene] for scene in args.scenes or found}
    journal, wanted = OutcomeJournal(args.journal), cells(chosen, args.variations)
    fill(journal, wanted, args.workers, show)
    made = {one.name: outcome for one in wanted if (outcome := journal.of(one)) is not None}
    table = markdown(made, chosen, args.variations)
    print(table)
    if args.write is not None:
        put(args.write, BEGIN, END, table)


if __name__ == "__main__":
    main()
