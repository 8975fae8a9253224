"""Gains of a jump by the height of a body."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np

from warp_softbody.body.character import Character
from warp_softbody.body.mesh_geometry import lumped_masses
from warp_softbody.controllers.motions.any_body import require_muscles, require_regions
from warp_softbody.controllers.motions.balance_gains import ANY_BODY
from warp_softbody.controllers.motions.for_any_body.ways import lies
from warp_softbody.controllers.motions.jump_gains import JumpGains
from warp_softbody.errors import InputError
from warp_softbody.inputs import checks

DEPTH, LANDING = 0.25, 0.9
"""Of the height of the centre of mass over the base: how deep it crouches, how high it lands."""

SPIN_WEIGHT = 0.5
"""Of the angular momentum: bodies that are not symmetric cannot have both momenta at once."""


def jump_gains(character: Character, height: float, way: float = 0.0) -> JumpGains:
    """Gains with which the base comes off the ground by about a height, m, on Earth.

    It lands a way, m, further along x: in the air for twice the time in which it rises.

    Raises:
        InputError: the body lies, or lacks a base or muscles.
    """
    require_regions("Jump", character, ("base",))
    require_muscles("Jump", character)
    if lies(character):
        raise InputError(
            f"Jump needs a body that stands, and character {character.name!r} lies: it is less "
            "than half as high as long"
        )
    mesh = character.mesh
    length = float(np.ptp(mesh.bounds, axis=0).max())
    height = checks.number("height of Jump", height, above=0.0, high=length, unit="m")
    way = checks.number("way of Jump", way, low=-length, high=length, unit="m")
    rises = math.sqrt(2.0 * height / length)
    mass = lumped_masses(mesh.tets, mesh.volumes, len(mesh.points))
    middle = mass @ mesh.points / mass.sum() - mesh.points[character.region("base")].mean(axis=0)
    reach = float(middle[2]) / length
    upright = ANY_BODY.upright_weight if len(character.regions.get("head", ())) else 0.0
    return JumpGains(
        launch=(0.5 * way / length / rises, 0.0, rises),
        way=(way / length, 0.0),
        depth=DEPTH * reach,
        height=LANDING * reach,
        spin_weight=SPIN_WEIGHT,
        # with held feet a chair came off the floor by a fifth of what it was asked for
        landing=replace(ANY_BODY, base_weight=0.0, upright_weight=upright, hold_within=0.0),
    )
