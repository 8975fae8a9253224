"""The letter T is a stem with two arms on top; it is the character that jumps with a twist."""

from __future__ import annotations

import numpy as np

from warp_softbody.body.character import Character
from warp_softbody.characters.fibers import four_upright, group, helix
from warp_softbody.characters.recipe import Recipe
from warp_softbody.characters.regions import EDGE, select, standing
from warp_softbody.characters.store import load_mesh

RECIPE = Recipe(
    name="letter_t",
    outline=((0.0, 0.0), (0.16, 0.0), (0.16, 0.84), (0.36, 0.84), (0.36, 1.0), (0.0, 1.0)),
    depth=0.32,
    size=0.084,
    tetgen_options={"nobisect": True, "mindihedral": 15.0, "minratio": 1.5},
)


def letter_t(*, coarse: int = 0) -> Character:
    """Letter T, 1 m high on z = 0, with four longitudinal fibres and three helical ones.

    The stem is 0.32 by 0.32 m, the arms are 0.72 m across and 0.16 m high. The helices wind once
    around the stem, right-handed: as they contract, the head turns clockwise seen from above.
    Regions: the underside `base`, its quadrants `base_patch_0` to `_3` (x and y: --, +-, -+, ++),
    the `head` (z >= 0.84 m), its upper face `head_top`, and the arms beyond the stem, `arm_left`
    (x < 0) and `arm_right`.
    """
    mesh = load_mesh("letter_t", coarse)
    x = mesh.points[:, 0]
    masks = standing(mesh, head=0.84)
    masks |= {"arm_left": x < -0.16 - EDGE, "arm_right": x > 0.16 + EDGE}
    helices = (
        helix(f"helical_{i}", 0.13, 2.0 * np.pi * i / 3.0, 1.0, (0.05, 0.95), 9) for i in range(3)
    )
    return Character(
        name="letter_t",
        mesh=mesh,
        muscles=(four_upright((0.12, 0.12), (0.02, 0.98), 6), group("helical", *helices)),
        regions=select(masks),
    )
