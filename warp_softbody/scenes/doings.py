"""What the character of a file can be asked to do, one thing or several in turn."""

from __future__ import annotations

import re
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field, replace
from typing import Any

from warp_softbody.body.character import Character
from warp_softbody.controllers.controller import Controller
from warp_softbody.controllers.motions.balance import Balance
from warp_softbody.controllers.motions.crawl import Crawl
from warp_softbody.controllers.motions.for_any_body.jumping import jump_gains
from warp_softbody.controllers.motions.for_any_body.taught import with_numbers
from warp_softbody.controllers.motions.for_any_body.ways import way_to_crawl, way_to_walk
from warp_softbody.controllers.motions.jump import Jump
from warp_softbody.controllers.motions.motion import Motion
from warp_softbody.controllers.motions.roll import Roll
from warp_softbody.controllers.motions.roll_gains import ANY_BODY as ROLLING
from warp_softbody.controllers.motions.sequence import Sequence
from warp_softbody.controllers.motions.walk import Walk
from warp_softbody.errors import InputError
from warp_softbody.inputs import checks
from warp_softbody.scenes.plan import Setting, Values
from warp_softbody.scenes.pushes import PUSH_SETTINGS

PUSH = replace(PUSH_SETTINGS[0], default=0.15)
"""One that a body without gains of its own should bear."""

NO_PUSH = replace(PUSH, default=0.0)
HEADING = Setting(
    name="heading", default=0.0, low=-3.2, high=3.2, unit="rad", help="from x towards y"
)
SPEED = Setting(
    name="speed", default=0.0, low=0.0, high=10.0, unit="m/s", help="of the plan; 0 for the usual"
)
HEIGHT = Setting(
    name="height",
    default=0.08,
    low=0.001,
    high=10.0,
    unit="m",
    help="to which the base is to come off the floor",
)
WAY = Setting(
    name="way",
    default=0.08,
    low=-10.0,
    high=10.0,
    unit="m",
    help="by which each jump goes ahead, along x",
)
JUMPS = Setting(name="jumps", default=1.0, low=1.0, high=100.0, help="how many", whole=True)
TURN = Setting(name="turn", default=6.2832, low=0.01, high=1000.0, unit="rad", help="by which")
DIRECTION = Setting(
    name="direction", default=1.0, low=-1.0, high=1.0, help="1 along x, -1 against it", whole=True
)


@dataclass(frozen=True)
class Doing:
    """Something that a character can be asked to do.

    Attributes:
        tells: ends the scene's description.
        make: the controller, with gains of its own or None for the usual ones.
        settings: of it, before those of the floor.
        push: at the head.
        seconds: usual length, s.
        usual: the gains that it has without others; None for what cannot be taught.
    """

    tells: str
    make: Callable[[Character, Values, Any], Controller]
    settings: tuple[Setting, ...] = ()
    push: Setting = NO_PUSH
    seconds: float = 10.0
    usual: Callable[[Character, Values], Any] | None = None

    def gains(self, character: Character, values: Values, taught: Mapping[str, float]) -> Any:
        """The usual gains with what a character has learnt; None where that is nothing."""
        if self.usual is None or not taught:
            return None
        return with_numbers(self.usual(character, values), taught)


def _speed(values: Values) -> float | None:
    return values["speed"] or None


def _hop(body: Character, values: Values, gains: Any) -> Controller:
    given = {name: values[name] for name in ("height", "way")}
    return Jump.for_(body, **given, jumps=int(values["jumps"]), gains=gains)


DOINGS = {
    "balance": Doing(
        "keeps its balance after a push at its head",
        lambda body, values, gains: Balance.for_(body),
        push=PUSH,
        seconds=5.0,
    ),
    "walk": Doing(
        "walks",
        lambda body, values, gains: Walk.for_(
            body, heading=values["heading"], speed=_speed(values), gains=gains
        ),
        (HEADING, SPEED),
        usual=lambda body, values: way_to_walk(body).gains,
    ),
    "crawl": Doing(
        "crawls",
        lambda body, values, gains: Crawl.for_(
            body, heading=values["heading"], speed=_speed(values), gains=gains
        ),
        (HEADING, SPEED),
        usual=lambda body, values: way_to_crawl(body, values["heading"]).gains,
    ),
    "jump": Doing(
        "jumps",
        lambda body, values, gains: Jump.for_(
            body, height=values["height"], jumps=int(values["jumps"])
        ),
        (HEIGHT, JUMPS),
        seconds=3.0,
    ),
    "hop": Doing(
        "hops ahead",
        _hop,
        (HEIGHT, WAY, replace(JUMPS, default=4.0)),
        usual=lambda body, values: jump_gains(body, values["height"], values["way"]),
    ),
    "roll": Doing(
        "rolls",
        lambda body, values, gains: Roll.for_(
            body, turn=values["turn"], direction=values["direction"], gains=gains
        ),
        (TURN, DIRECTION),
        usual=lambda body, values: ROLLING,
    ),
}
"""By name; the first is done where nothing is asked for."""


END = re.compile(r"(\d+(?:\.\d*)?|\.\d+)\s*(m|s)")
"""After a colon: how far or how long something is done."""

Taught = Mapping[str, Mapping[str, float]]
"""Gains that a character has learnt, by what they are for."""


@dataclass(frozen=True)
class Asked:
    """One of the things that are asked for.

    Attributes:
        name: in `DOINGS`.
        ends: after so many ``seconds`` or such a ``distance``, m; by itself where it is empty.
    """

    name: str
    ends: Mapping[str, float] = field(default_factory=dict)

    @property
    def doing(self) -> Doing:
        """What it is."""
        return DOINGS[self.name]


def asked(text: str) -> tuple[Asked, ...]:
    """What a text asks for: a name of `DOINGS`, or several, as "walk:2m,jump,balance:3s".

    Raises:
        InputError: one of them is not known, or ends as nothing does.
    """
    if not isinstance(text, str):
        checks.refuse("what a character does", f"a text of {', '.join(DOINGS)}", text)
    return tuple(_step(part.strip()) for part in text.split(","))


def _step(text: str) -> Asked:
    name, colon, end = (part.strip() for part in text.partition(":"))
    checks.choice("what a character does", name, DOINGS)
    if not colon:
        return Asked(name)
    found = END.fullmatch(end)
    if found is None or float(found[1]) == 0.0:
        raise InputError(
            f"what a character does must end after metres or seconds, as {name}:2m or {name}:3s, "
            f"not {checks.shown(text)}"
        )
    return Asked(name, {"distance" if found[2] == "m" else "seconds": float(found[1])})


def settings_of(steps: tuple[Asked, ...]) -> tuple[Setting, ...]:
    """Settings of all that is asked for, each once; several things go without a push."""
    found = {one.name: one for step in steps for one in step.doing.settings}
    push = steps[0].doing.push if len(steps) == 1 else NO_PUSH
    return (*found.values(), push, *PUSH_SETTINGS[1:])


def controller_of(
    steps: tuple[Asked, ...], character: Character, values: Values, taught: Taught
) -> Controller:
    """What makes a character do what is asked for.

    Raises:
        InputError: it cannot, or one of several never ends.
    """
    made = []
    for step in steps:
        gains = step.doing.gains(character, values, taught.get(step.name, {}))
        controller = step.doing.make(character, values, gains)
        seconds, distance = step.ends.get("seconds"), step.ends.get("distance")
        made.append(
            Motion(controller=controller, seconds=seconds, distance=distance, name=step.name)
        )
    for step, motion in zip(steps[:-1], made, strict=False):
        if not motion.ends:
            raise InputError(
                f"to {step.name} never ends, but something else is to follow: say how far or how "
                f"long, as {step.name}:2m or {step.name}:5s"
            )
    return made[0].controller if len(made) == 1 and not steps[0].ends else Sequence(made)
