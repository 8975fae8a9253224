"""The letter F is a stem on a foot with two arms to the right; it is the character that slides."""

from __future__ import annotations

from warp_softbody.body.character import Character
from warp_softbody.characters.fibers import four_upright
from warp_softbody.characters.recipe import Recipe
from warp_softbody.characters.regions import EDGE, select, standing
from warp_softbody.characters.store import load_mesh

RECIPE = Recipe(
    name="letter_f",
    outline=(
        (-0.2, 0.0),
        (0.2, 0.0),
        (0.2, 0.1),
        (0.12, 0.1),
        (0.12, 0.44),
        (0.28, 0.44),
        (0.28, 0.56),
        (0.12, 0.56),
        (0.12, 0.88),
        (0.36, 0.88),
        (0.36, 1.0),
        (-0.16, 1.0),
        (-0.16, 0.1),
        (-0.2, 0.1),
    ),
    depth=0.3,
    size=0.106,
    mirrors="y",
)


def letter_f(*, coarse: int = 0) -> Character:
    """Letter F, 1 m high on z = 0, with four longitudinal fibres in its stem.

    The foot is 0.4 (x) by 0.3 (y) by 0.1 (z) m and centred on the z axis. The stem, 0.28 m wide,
    stands 0.02 m to the left of it, which balances the arms that reach to x = 0.36 and 0.28 m.
    Regions: the underside `base`, its quadrants `base_patch_0` to `base_patch_3` (x and y: --, +-,
    -+, ++), the `head` (z >= 0.88 m), its upper face `head_top`, and the arms beyond the stem,
    `arm_upper` and `arm_lower`.
    """
    mesh = load_mesh("letter_f", coarse)
    x, _, z = mesh.points.T
    arm = (x > 0.12 + EDGE) & (z > 0.44 - EDGE)
    masks = standing(mesh, head=0.88)
    masks |= {"arm_upper": arm & (z > 0.88 - EDGE), "arm_lower": arm & (z < 0.56 + EDGE)}
    return Character(
        name="letter_f",
        mesh=mesh,
        muscles=(four_upright((0.11, 0.12), (0.02, 0.98), 12, middle=-0.02),),
        regions=select(masks),
    )
