"""Several scenes share a push at the head, measured in body weights."""

from __future__ import annotations

from warp_softbody.body.character import Character
from warp_softbody.scenes.plan import Setting, Values
from warp_softbody.world.scene import STANDARD_GRAVITY, Push

PUSH_START = 0.5  # s

PUSH_SETTINGS = (
    Setting(
        name="push",
        default=0.3,
        low=-2.0,
        high=2.0,
        unit="body weights",
        help="push at the head along +x, 0.5 s after the start; 0 for none",
    ),
    Setting(
        name="push_seconds", default=0.2, low=0.0, high=10.0, unit="s", help="how long it lasts"
    ),
    Setting(
        name="friction", default=0.8, low=0.0, high=10.0, help="Coulomb coefficient of the floor"
    ),
)


def head_push(character: Character, values: Values) -> tuple[Push, ...]:
    """The push that the settings ask for, if any."""
    if not values["push"]:
        return ()
    weight = character.material.density * character.mesh.volume * STANDARD_GRAVITY
    force = (values["push"] * weight, 0.0, 0.0)
    return (Push(region="head", force=force, start=PUSH_START, duration=values["push_seconds"]),)
