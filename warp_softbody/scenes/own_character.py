"""A character from a user's file stands on a floor, where it does what it is asked to."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
from pathlib import Path

from warp_softbody.body.character import Character
from warp_softbody.body.character_files import EXTENSION
from warp_softbody.body.mesh_files import FORMATS, SURFACES
from warp_softbody.controllers.controller import Controller
from warp_softbody.controllers.motions.balance import Balance
from warp_softbody.controllers.motions.crawl import Crawl
from warp_softbody.controllers.motions.jump import Jump
from warp_softbody.controllers.motions.roll import Roll
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
        make: the controller.
        settings: of it, before those of the floor.
        push: at the head.
        seconds: usual length, s.
    """

    tells: str
    make: Callable[[Character, Values], Controller]
    settings: tuple[Setting, ...] = ()
    push: Setting = NO_PUSH
    seconds: float = 10.0


def _speed(values: Values) -> float | None:
    return values["speed"] or None


DOINGS = {
    "balance": Doing(
        "keeps its balance after a push at its head",
        lambda body, values: Balance.for_(body),
        push=PUSH,
        seconds=5.0,
    ),
    "walk": Doing(
        "walks",
        lambda body, values: Walk.for_(body, heading=values["heading"], speed=_speed(values)),
        (HEADING, SPEED),
    ),
    "crawl": Doing(
        "crawls",
        lambda body, values: Crawl.for_(body, heading=values["heading"], speed=_speed(values)),
        (HEADING, SPEED),
    ),
    "jump": Doing(
        "jumps",
        lambda body, values: Jump.for_(body, height=values["height"], jumps=int(values["jumps"])),
        (HEIGHT, JUMPS),
        seconds=3.0,
    ),
    "roll": Doing(
        "rolls",
        lambda body, values: Roll.for_(body, turn=values["turn"], direction=values["direction"]),
        (TURN, DIRECTION),
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

    def build(values: Values) -> tuple[Scene, Controller | None]:
        scene = Scene(
            character=character,
            ground=Plane(friction=values["friction"]),
            pushes=head_push(character, values),
        )
        if do is None and not character.muscles:
            return scene, None
        return scene, doing.make(character, values)

    return SceneRecipe(
        name=character.name,
        description=f"{character.name} {doing.tells}",
        settings=(*doing.settings, doing.push, *PUSH_SETTINGS[1:]),
        build=build,
        seconds=doing.seconds,
        time_step=1.0 / 60.0,
    )
