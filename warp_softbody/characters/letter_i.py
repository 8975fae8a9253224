"""The letter I is a stem between base and head; it is the character that balances."""

from __future__ import annotations

from typing import TYPE_CHECKING

from warp_softbody.body.character import Character
from warp_softbody.body.muscles import MuscleGroup
from warp_softbody.characters.fibers import four_upright, group, ring
from warp_softbody.characters.recipe import Recipe
from warp_softbody.characters.regions import select, standing
from warp_softbody.characters.store import load_mesh, load_recipe

if TYPE_CHECKING:
    import trimesh

RECIPE = Recipe(
    name="letter_i",
    outline=(
        (0.0, 0.0),
        (0.25, 0.0),
        (0.25, 0.1),
        (0.15, 0.1),
        (0.15, 0.9),
        (0.25, 0.9),
        (0.25, 1.0),
        (0.0, 1.0),
    ),
    depth=0.3,
    size=0.084,
    tetgen_options={"nobisect": True, "mindihedral": 10.0, "minratio": 1.2},
)
RING_HEIGHTS = (0.11, 0.24, 0.37, 0.5, 0.63, 0.76, 0.89)


def letter_i(*, coarse: int = 0) -> Character:
    """Letter I, 1 m high on z = 0 and centred on the z axis, with four longitudinal fibres.

    Base and head are 0.5 (x) by 0.3 (y) by 0.1 (z) m, the stem between them 0.3 by 0.3 m.
    Regions: the underside `base`, its quadrants `base_patch_0` to `base_patch_3` (x and y: --,
    +-, -+, ++; nodes on x = 0 or y = 0 belong to both sides), the `head` and its upper face
    `head_top`.
    """
    return _letter("letter_i", (_longitudinal(),), coarse)


def letter_i_jump() -> Character:
    """Return letter I with seven more radial fibres, with which it jumps."""
    rings = (
        ring(f"radial_{i}", (0.0, 0.0, z), (0.12, 0.0, 0.0), (0.0, 0.12, 0.0), 8)
        for i, z in enumerate(RING_HEIGHTS)
    )
    return _letter("letter_i_jump", (_longitudinal(), group("radial", *rings)))


def letter_i_surface() -> trimesh.Trimesh:
    """Return the closed surface of the letter, as a user's own file would hold it."""
    return load_recipe("letter_i").surface()


def _letter(name: str, muscles: tuple[MuscleGroup, ...], coarse: int = 0) -> Character:
    mesh = load_mesh("letter_i", coarse)
    regions = select(standing(mesh, head=0.9))
    return Character(name=name, mesh=mesh, muscles=muscles, regions=regions)


def _longitudinal() -> MuscleGroup:
    return four_upright((0.12, 0.12), (0.02, 0.98), 12)
