"""What a character is made of by the shape of its mesh: regions, muscles and a firm material."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np

from warp_softbody.body.making.firmness import STRENGTH, firm_material
from warp_softbody.body.making.limb_fibers import limb_fibers
from warp_softbody.body.making.limbs import Limb, find_limbs
from warp_softbody.body.making.shape_regions import IntArray, shape_regions
from warp_softbody.body.material import Material
from warp_softbody.body.mesh import TetMesh
from warp_softbody.body.muscles import MuscleGroup

MOST_BENDING = 2
"""Feet on which a body keeps its balance by bending, as on one sole: it is not made firmer."""

KERNEL = 0.9
"""Width over which muscles spread, over the mean radius of limbs."""


@dataclass(frozen=True)
class Made:
    """What a character is made of, and what was found on the way.

    Attributes:
        name, mesh, material, muscles, regions: as a `Character` takes them.
        limbs: of its shape.
        repairs: what was done to the surface, a clause each.
    """

    name: str
    mesh: TetMesh
    material: Material
    muscles: tuple[MuscleGroup, ...]
    regions: Mapping[str, IntArray]
    limbs: tuple[Limb, ...]
    repairs: tuple[str, ...]

    @property
    def parts(self) -> dict[str, Any]:
        """Arguments of `Character`."""
        keys = ("name", "mesh", "material", "muscles", "regions")
        return {key: getattr(self, key) for key in keys}


def made_of_mesh(
    mesh: TetMesh,
    name: str,
    density: float,
    repairs: tuple[str, ...] = (),
    limbs: tuple[Limb, ...] | None = None,
) -> Made:
    """Regions, muscles and material of a mesh that stands on z = 0; its own regions are kept.

    Limbs are looked for where none are given.
    """
    limbs = find_limbs(mesh) if limbs is None else limbs
    regions = {**shape_regions(mesh, limbs), **mesh.regions}
    # on two it stands by bending, as on one sole
    on_feet = sum(name.startswith("foot_") for name in regions) > MOST_BENDING
    material = firm_material(mesh, limbs, density=density, on_feet=on_feet)
    lengths = np.array([limb.length for limb in limbs])
    radius = float(lengths @ np.array([limb.radius for limb in limbs]) / lengths.sum())
    group = MuscleGroup(
        fibers=limb_fibers(mesh, limbs),
        strength=STRENGTH * material.young_modulus,
        kernel_width=KERNEL * radius,
        name="longitudinal",
    )
    return Made(name, mesh, material, (group,), regions, limbs, repairs)
