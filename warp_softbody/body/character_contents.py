"""A character as plain values and arrays by name, and back."""

from __future__ import annotations

import io
from collections.abc import Mapping
from dataclasses import asdict
from typing import Any, Protocol

import numpy as np
import numpy.typing as npt

from warp_softbody.body.directional_friction import DirectionalFriction
from warp_softbody.body.material import Material
from warp_softbody.body.mesh import TetMesh
from warp_softbody.body.muscles import Fiber, FiberKind, MuscleGroup
from warp_softbody.body.skin import Skin, SkinMaterial

Array = npt.NDArray[Any]


class Kept(Protocol):
    """What is kept of a character: all that its constructor takes."""

    @property
    def name(self) -> str:
        """As `Character` has it."""

    @property
    def mesh(self) -> TetMesh:
        """As `Character` has it."""

    @property
    def material(self) -> Material:
        """As `Character` has it."""

    @property
    def muscles(self) -> tuple[MuscleGroup, ...]:
        """As `Character` has it."""

    @property
    def regions(self) -> Mapping[str, npt.NDArray[np.int32]]:
        """As `Character` has it."""

    @property
    def skin(self) -> Skin | None:
        """As `Character` has it."""

    @property
    def fixed(self) -> npt.NDArray[np.int32]:
        """As `Character` has it."""

    @property
    def color(self) -> tuple[float, float, float]:
        """As `Character` has it."""

    @property
    def directional_friction(self) -> tuple[DirectionalFriction, ...]:
        """As `Character` has it."""

    @property
    def materials(self) -> Mapping[str, Material]:
        """As `Character` has it."""


def described(character: Kept, stored: Any) -> dict[str, Any]:
    """Plain values of a character; ``stored`` takes an array and gives the name it is kept by."""
    mesh = character.mesh
    return {
        "name": character.name,
        "color": list(character.color),
        "mesh": {
            "points": stored(mesh.points),
            "tets": stored(mesh.tets),
            "node_of": stored(mesh.node_of),
            "regions": {name: stored(nodes) for name, nodes in mesh.regions.items()},
        },
        "material": asdict(character.material),
        "muscles": [
            {
                "name": group.name,
                "strength": group.strength,
                "kernel_width": group.kernel_width,
                "fibers": [
                    {
                        "name": fiber.name,
                        "kind": fiber.kind.value,
                        "vertices": stored(fiber.vertices),
                    }
                    for fiber in group.fibers
                ],
            }
            for group in character.muscles
        ],
        "skin": None if character.skin is None else _described_skin(character.skin, stored),
        "regions": {name: stored(nodes) for name, nodes in character.regions.items()},
        "fixed": stored(character.fixed),
        "directional_friction": [asdict(law) for law in character.directional_friction],
        "materials": {name: asdict(own) for name, own in character.materials.items()},
    }


SKIN_ARRAYS = ("points", "faces", "texture_points", "texture_faces", "face_materials")
"""Fields of a `Skin` that are arrays."""


def _described_skin(skin: Skin, stored: Any) -> dict[str, Any]:
    materials = []
    for material in skin.materials:
        texture = stored(np.frombuffer(material.texture, dtype=np.uint8))
        materials.append({**asdict(material), "texture": texture})
    return {**{key: stored(getattr(skin, key)) for key in SKIN_ARRAYS}, "materials": materials}


class Arrays:
    """Arrays of a file by the names that its text gives."""

    def __init__(self, entries: Mapping[str, bytes]) -> None:
        """Take the bytes of .npy files by their names."""
        self._entries = entries

    def __getitem__(self, name: str) -> Array:
        """Array of a name; one that would have to be run is refused."""
        data = io.BytesIO(self._entries[name])
        array: Array = np.lib.format.read_array(data, allow_pickle=False)
        return array

    def of_names(self, names: Mapping[str, str]) -> dict[str, Array]:
        """Arrays by other names."""
        return {name: self[array] for name, array in names.items()}


def arguments(described: Mapping[str, Any], arrays: Arrays) -> dict[str, Any]:
    """Arguments of `Character` of plain values, which may hold anything, and arrays by name."""
    mesh = described["mesh"]
    return dict(
        name=described["name"],
        mesh=TetMesh(
            arrays[mesh["points"]],
            arrays[mesh["tets"]],
            arrays[mesh["node_of"]],
            arrays.of_names(mesh["regions"]),
        ),
        material=Material(**described["material"]),
        muscles=tuple(_group(group, arrays) for group in described["muscles"]),
        skin=_skin(described["skin"], arrays),
        regions=arrays.of_names(described["regions"]),
        fixed=arrays[described["fixed"]],
        color=tuple(described["color"]),
        directional_friction=tuple(
            DirectionalFriction(**law) for law in described["directional_friction"]
        ),
        # older files have none
        materials={n: Material(**own) for n, own in described.get("materials", {}).items()},
    )


def _skin(described: Mapping[str, Any] | None, arrays: Arrays) -> Skin | None:
    if described is None:
        return None
    materials = tuple(
        SkinMaterial(**{**one, "texture": arrays[one["texture"]].tobytes()})
        for one in described["materials"]
    )
    return Skin(**{key: arrays[described[key]] for key in SKIN_ARRAYS}, materials=materials)


def _group(described: Mapping[str, Any], arrays: Arrays) -> MuscleGroup:
    fibers = tuple(
        Fiber(vertices=arrays[fiber["vertices"]], kind=FiberKind(fiber["kind"]), name=fiber["name"])
        for fiber in described["fibers"]
    )
    return MuscleGroup(
        fibers=fibers,
        strength=described["strength"],
        kernel_width=described["kernel_width"],
        name=described["name"],
    )
