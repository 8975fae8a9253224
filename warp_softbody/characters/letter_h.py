"""The letter H has two legs and a bar; it is the character that exercises."""

from __future__ import annotations

from warp_softbody.body.character import Character
from warp_softbody.characters.fibers import QUADRANTS, group, ring, upright
from warp_softbody.characters.recipe import Recipe
from warp_softbody.characters.regions import EDGE, select, standing
from warp_softbody.characters.store import load_mesh

RECIPE = Recipe(
    name="letter_h",
    outline=(
        (0.0, 0.4),
        (0.12, 0.4),
        (0.12, 0.0),
        (0.4, 0.0),
        (0.4, 1.0),
        (0.12, 1.0),
        (0.12, 0.6),
        (0.0, 0.6),
    ),
    depth=0.3,
    size=0.078,
    tetgen_options={"nobisect": True, "mindihedral": 15.0, "minratio": 1.5},
)
LEGS = {"left": -0.26, "right": 0.26}


def letter_h(*, coarse: int = 0) -> Character:
    """Letter H, 1 m high on z = 0, each leg with four longitudinal fibres and a radial one.

    The legs are 0.28 (x) by 0.3 (y) m and stand 0.24 m apart; the bar is 0.2 m high. Regions: the
    underside `base`, its quadrants `base_patch_0` to `_3` (the front and back halves of the feet;
    x and y: --, +-, -+, ++), the feet `foot_left` (x < 0) and `foot_right`, the tips `head` of
    the legs (z >= 0.9 m; `head_left`, `head_right`), their upper faces `head_top`, and the `bar`.
    """
    mesh = load_mesh("letter_h", coarse)
    x, _, z = mesh.points.T
    masks = standing(mesh, head=0.9)
    for name, side in (("left", x < 0.0), ("right", x > 0.0)):
        masks |= {f"foot_{name}": masks["base"] & side, f"head_{name}": masks["head"] & side}
    masks["bar"] = (abs(x) < 0.12 + EDGE) & (abs(z - 0.5) < 0.1 + EDGE)
    longitudinal = (
        upright(f"longitudinal_{leg}_{i}", middle + 0.1 * side_x, 0.11 * side_y, (0.02, 0.98), 5)
        for leg, middle in LEGS.items()
        for i, (side_x, side_y) in enumerate(QUADRANTS)
    )
    radial = (
        ring(f"radial_{leg}", (middle, 0.0, 0.5), (0.1, 0.0, 0.0), (0.0, 0.11, 0.0), 6)
        for leg, middle in LEGS.items()
    )
    return Character(
        name="letter_h",
        mesh=mesh,
        muscles=(group("longitudinal", *longitudinal), group("radial", *radial)),
        regions=select(masks),
    )
