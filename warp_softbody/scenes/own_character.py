"""A character from a user's file stands on a floor, where it does what it is asked to."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

from warp_softbody.body.character import Character
from warp_softbody.body.character_files import EXTENSION
from warp_softbody.body.lessons import read_lessons
from warp_softbody.body.mesh_files import FORMATS, SURFACES
from warp_softbody.controllers.controller import Controller
from warp_softbody.controllers.motions.balance import Balance
from warp_softbody.controllers.motions.crawl import Crawl
from warp_softbody.controllers.motions.for_any_body.jumping import jump_gains
from warp_softbody.controllers.motions.for_any_body.taught import with_numbers
from warp_softbody.controllers.motions.for_any_body.ways import way_to_crawl, way_to_walk
from warp_softbody.controllers.motions.jump import Jump
from warp_softbody.controllers.motions.roll import Roll
from warp_softbody.controllers.motions.roll_gains import ANY_BODY as ROLLING
from warp_softbody.controllers.motions.walk import Walk
from warp_softbody.errors import InputError
from warp_softbody.inputs import checks
from warp_softbody.scenes.plan import SceneRecipe, Setting, Values
from warp_softbody.scenes.pushes import PUSH_SETTINGS, head_push
from warp_softbody.world.ground import Plane
from warp_softbody.world.scene import Scene

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


def recipe(name: str, do: str | None = None) -> SceneRecipe:
    """The scene of a character's file, in which it does one of `DOINGS`.

    Raises:
        InputError: the file is missing, of another kind, or holds no character.
    """
    suffix = Path(name).suffix.lower()
    if suffix in (*SURFACES, ".glb", *FORMATS):
        raise InputError(
            f"{name} is a shape and no scene; `warp-softbody character {name} -o "
            f"{Path(name).stem}.char` makes a character of it, which can be run"
        )
    if suffix != EXTENSION:
        raise InputError(
            f"there is no scene {name!r}; a character's file, which can be run, ends in {EXTENSION}"
        )
    doing = DOINGS[checks.choice("what a character does", do or "balance", DOINGS)]
    character = Character.load(name)
    taught = read_lessons(Path(name)).get(do or "balance", {})

    def build(values: Values) -> tuple[Scene, Controller | None]:
        scene = Scene(
            character=character,
            ground=Plane(friction=values["friction"]),
            pushes=head_push(character, values),
        )
        if do is None and not character.muscles:
            return scene, None
        return scene, doing.make(character, values, doing.gains(character, values, taught))

    return SceneRecipe(
        name=character.name,
        description=f"{character.name} {doing.tells}",
        settings=(*doing.settings, doing.push, *PUSH_SETTINGS[1:]),
        build=build,
        seconds=doing.seconds,
        time_step=1.0 / 60.0,
    )
