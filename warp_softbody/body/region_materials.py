"""Materials of some regions of a body: how stiff and dense each tet is beside the others.

The regions' materials differ from the body's in Young's modulus and density. Poisson's ratio, the
law of volume and the damping are those of the whole body, so that its stiffness matrix is that of
one material with a factor for each tet.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from warp_softbody.arrays import FloatArray
from warp_softbody.body.material import Material
from warp_softbody.errors import InputError
from warp_softbody.inputs import checks, input_kinds

OWN = ("young_modulus", "density")
"""What a region's material may have of its own."""


class TetMaterials(NamedTuple):
    """Of each tet: its Young's modulus over that of the body's material, and density, kg/m^3."""

    stiffness: FloatArray
    densities: FloatArray


def checked_materials(
    name: str,
    material: Material,
    given: object,
    tets: npt.NDArray[np.integer],
    regions: Mapping[str, npt.NDArray[np.int32]],
) -> dict[str, Material]:
    """Materials by region, each of which goes with that of the body and with its tets (m, 4).

    Raises:
        InputError: something else, a material that differs in more than it may, or of a region
            without a tet.
    """
    found = {}
    for region, own in input_kinds.mapping(f"Character.materials of {name!r}", given).items():
        label = f"material of the region {region!r} of {name!r}"
        input_kinds.name(f"name of a region of Character.materials of {name!r}", region)
        checks.instance(label, own, Material)
        like = replace(own, **{key: getattr(material, key) for key in OWN})
        if like != material:
            raise InputError(
                f"{label} must have the poisson_ratio, volume and damping of the body's, and may "
                f"differ in {' and '.join(OWN)}"
            )
        if region in regions and not holds_tet(tets, regions[region]):
            raise InputError(f"{label}: {without_tet(region)}")
        found[region] = own
    return found


def holds_tet(tets: npt.NDArray[np.integer], nodes: npt.NDArray[np.integer]) -> bool:
    """Whether a tet (m, 4) has all its nodes among these."""
    return bool(np.isin(tets, nodes).all(axis=1).any())


def without_tet(region: str) -> str:
    """Why a region cannot have a material of its own."""
    return (
        f"region {region!r} holds no whole tet, so that a material of its own would change "
        "nothing; its tets are those whose four nodes are in it"
    )


def tet_owners(
    tets: npt.NDArray[np.integer],
    count: int,
    materials: Mapping[str, Material],
    regions: Mapping[str, npt.NDArray[np.int32]],
) -> npt.NDArray[np.intp]:
    """Which material tets (m, 4) of ``count`` nodes have: its number in the mapping, or -1.

    A region's are those with all four nodes in it; where regions overlap, the one that is named
    last counts.
    """
    owners = np.full(len(tets), -1)
    for number, name in enumerate(materials):
        inside = np.zeros(count, dtype=bool)
        inside[regions[name]] = True
        owners[inside[tets].all(axis=1)] = number
    return owners


def tet_materials(
    tets: npt.NDArray[np.integer],
    count: int,
    material: Material,
    materials: Mapping[str, Material],
    regions: Mapping[str, npt.NDArray[np.int32]],
) -> TetMaterials:
    """The materials of tets (m, 4) of ``count`` nodes, by `tet_owners`."""
    stiffness = np.ones(len(tets))
    densities = np.full(len(tets), material.density)
    owners = tet_owners(tets, count, materials, regions)
    for number, own in enumerate(materials.values()):
        chosen = owners == number
        stiffness[chosen] = own.young_modulus / material.young_modulus
        densities[chosen] = own.density
    return TetMaterials(stiffness, densities)
