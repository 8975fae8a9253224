"""What is timed step by step: the beam, the dropped block, controlled letters, and many letters.

Nothing of `warp_softbody` is imported before a work is made, so that a worker may choose whose.
"""

from __future__ import annotations

import importlib
from collections.abc import Callable
from dataclasses import dataclass, replace
from functools import partial
from typing import Any

Advance = Callable[[], object]
"""Takes one step."""

OURS = "ours"
OURS_FLOAT64 = "ours float64"
PEERS = {"MuJoCo": "mujoco", "Pardiso": "pypardiso", "Drake": "pydrake"}
"""Other programs and the modules that they are imported by."""

BEAMS = {810: 200, 10_290: 40, 51_840: 15}
"""Timed steps by number of tets."""

CONTROLLED = ("balance-i", "walk-x", "crawl-i", "exercise-h", "jump-t")
MANY = 16
SPACING = 1.5
"""Between letters in a row, m; they never touch."""

PEER_TOLERANCE = 1e-8
PEER_ITERATIONS = 10_000


@dataclass(frozen=True, kw_only=True)
class Work:
    """A row of the table.

    Attributes:
        name: by which it is asked for.
        about: what is done.
        unit: of what is measured.
        make: the work at its beginning, by the name of a program.
        peers: whether other programs can do it too.
        skipped: steps before the clock starts.
        steps: that are timed.
        scale: what the mean time of a step, s, is multiplied by.
        turn: steps of one program before another has its turn.
    """

    name: str
    about: str
    make: Callable[[str], Advance]
    steps: int
    unit: str = "ms a step"
    peers: bool = False
    skipped: int = 2
    scale: float = 1e3
    turn: int = 5


def works() -> dict[str, Work]:
    """All rows by name, in the order of the table."""
    rows = [
        Work(
            name=f"beam-{tets}",
            about=f"clamped beam, {tets:,} tets",
            make=partial(_beam, tets),
            peers=True,
            steps=steps,
        )
        for tets, steps in BEAMS.items()
    ]
    block = partial(Work, skipped=1, steps=99, turn=11)
    rows += [
        block(
            name="drop-block-7",
            about="dropped block, 7 cells a side",
            make=partial(_scene, "drop-block", cells=7),
            unit="ms a simulated s",
            scale=1e5,
        ),
        block(
            name="drop-block-24",
            about="dropped block, 24 cells a side",
            make=partial(_scene, "drop-block", cells=24),
        ),
    ]
    controlled = partial(Work, skipped=60, steps=150, turn=15)
    rows += [
        controlled(name=name, about=f"`{name}`, controlled", make=partial(_scene, name))
        for name in CONTROLLED
    ]
    many = partial(Work, unit="ms a step and letter", scale=1e3 / MANY, steps=60)
    rows += [
        many(name="many-passive", about=f"{MANY} passive letters", make=_many_passive),
        many(name="many-controlled", about=f"{MANY} of `balance-i`", make=_many_controlled),
    ]
    return {row.name: row for row in rows}


def _beam(tets: int, program: str) -> Advance:
    """The clamped beam, by this program in either precision or by a peer."""
    from benchmarks.beam.cantilever import TIME_STEP, cantilever

    def of(module: str, name: str, **more: Any) -> Any:
        return getattr(importlib.import_module(module), name)(cantilever(tets), TIME_STEP, **more)

    peers = "warp_softbody.accuracy.runs.peers"
    if program == "MuJoCo":
        settings = {"tolerance": PEER_TOLERANCE, "iterations": PEER_ITERATIONS}
        made = of(f"{peers}.mujoco_flex", "MujocoBeam", **settings)
    elif program == "Pardiso":
        made = of(f"{peers}.pardiso_step", "PardisoBeam")
    elif program == "Drake":
        made = of("benchmarks.speed.drake_beam", "DrakeBeam")
    else:
        precision = "float32" if program == OURS else "float64"
        made = of("benchmarks.beam.ours", "OurBeam", precision=precision)
    step: Advance = made.step
    return step


def _scene(name: str, program: str, **settings: float) -> Advance:
    """A shipped scene under its controller, with the defaults of `run` but never asleep."""
    import warp_softbody as package

    plan = package.scenes.make(name, settings)
    options = package.SimulationOptions(time_step=plan.time_step, sleep=False)
    return package.Simulation(plan.scene, plan.controller, options=options).step


def _many_passive(program: str) -> Advance:
    """Letters without muscles: a batch, or beside each other in one scene where there are none."""
    import warp_softbody as package

    letter = replace(package.characters.letter_i(), muscles=())
    ground = package.Plane(friction=0.8, offset=-0.05)
    options = package.SimulationOptions(time_step=1.0 / 60.0, precision="float32", sleep=False)
    if hasattr(package, "Batch"):
        scene = package.Scene(character=letter, ground=ground)
        return package.Batch(scene, MANY, options=options).step
    from warp_softbody.world.joined_bodies import placed

    places = [(SPACING * (k % 4), SPACING * (k // 4), 0.0) for k in range(MANY)]
    others = tuple(
        package.Body(character=placed(letter, name=f"letter_{k}", translation=place))
        for k, place in enumerate(places)
        if k > 0
    )
    scene = package.Scene(character=letter, others=others, ground=ground)
    return package.Simulation(scene, options=options).step


def _many_controlled(program: str) -> Advance:
    """A batch of `balance-i`, or runs of it one after the other where there are none."""
    import warp_softbody as package

    if not hasattr(package, "Batch"):
        runs = [_scene("balance-i", program) for _ in range(MANY)]
        return lambda: [step() for step in runs]
    plans = [package.scenes.make("balance-i", {}) for _ in range(MANY)]
    options = package.SimulationOptions(time_step=plans[0].time_step, sleep=False)

    def planned(member: Any) -> Any:
        return replace(member, controller=plans[member.index].controller)

    return package.Batch(plans[0].scene, MANY, planned, options=options).step
