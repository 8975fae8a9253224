"""A `Character` is a body with its material, its muscles and its named regions."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from functools import cached_property
from pathlib import Path
from types import MappingProxyType
from typing import TYPE_CHECKING

import numpy as np
import numpy.typing as npt
from scipy.sparse import csr_array

from warp_softbody.arrays import FloatArray
from warp_softbody.body.character_files import load_character, save_character
from warp_softbody.body.directional_friction import (
    DirectionalFriction,
    NodeFriction,
    friction_by_node,
)
from warp_softbody.body.material import Material
from warp_softbody.body.mesh import TetMesh
from warp_softbody.body.mesh_geometry import lumped_masses
from warp_softbody.body.muscles import Fiber, MuscleGroup
from warp_softbody.body.region_materials import TetMaterials, checked_materials, tet_materials
from warp_softbody.body.skin import Skin
from warp_softbody.body.skin_binding import bind
from warp_softbody.errors import InputError
from warp_softbody.inputs import checks, input_kinds
from warp_softbody.inputs.records import FrozenValue

if TYPE_CHECKING:
    import trimesh

IntArray = npt.NDArray[np.int32]


@dataclass(frozen=True, kw_only=True, eq=False, repr=False)
class Character(FrozenValue):
    """A body with everything about it that does not change while it moves.

    Attributes:
        name: also the name of its prim in the stage, so a valid identifier.
        mesh: rest shape.
        material: elastic constants, density and damping.
        muscles: groups of fibres; empty for a passive body.
        regions: nodes by name ("base", "head", ...); given as indices in any order or as a mask of
            the mesh's nodes, kept as ascending indices (k,) int32; those of the mesh are taken up.
        fixed: nodes that never move, given and kept likewise.
        color: display colour, linear RGB in 0..1.
        directional_friction: of regions that slide more easily one way than another.
        materials: of regions that are stiffer or denser than the rest, by their names: of the tets
            whose four nodes are in the region, one at least; of the last one where several are.
        skin: the surface that is seen; None for that of the mesh, or for the tets' own.
    """

    name: str
    mesh: TetMesh
    material: Material = field(default_factory=Material)
    muscles: tuple[MuscleGroup, ...] = ()
    regions: Mapping[str, IntArray] = field(default_factory=dict)
    fixed: IntArray = field(default_factory=lambda: np.zeros(0, dtype=np.int32))
    color: tuple[float, float, float] = (0.80, 0.30, 0.24)
    directional_friction: tuple[DirectionalFriction, ...] = ()
    skin: Skin | None = None
    materials: Mapping[str, Material] = field(default_factory=dict)

    def __post_init__(self) -> None:
        """Check the name and the index sets against the mesh."""
        name = input_kinds.identifier("Character.name", self.name)
        mesh = checks.instance("Character.mesh", self.mesh, TetMesh)
        checks.instance("Character.material", self.material, Material)
        count = len(mesh.points)
        named = {**mesh.regions, **input_kinds.mapping("Character.regions", self.regions)}
        regions = {
            input_kinds.name(f"name of a region of {name!r}", region): input_kinds.node_set(
                f"region {region!r} of {name!r}", nodes, count
            )
            for region, nodes in named.items()
        }
        checks.keep(
            self,
            muscles=checks.items("Character.muscles", self.muscles, MuscleGroup),
            regions=MappingProxyType(regions),
            fixed=input_kinds.node_set(f"Character.fixed of {name!r}", self.fixed, count),
            color=input_kinds.color(f"Character.color of {name!r}", self.color),
            skin=mesh.skin
            if self.skin is None
            else checks.instance("Character.skin", self.skin, Skin),
            directional_friction=checks.items(
                "Character.directional_friction", self.directional_friction, DirectionalFriction
            ),
        )
        input_kinds.distinct(f"muscle groups of {name!r}", (group.name for group in self.muscles))
        input_kinds.distinct(f"fibres of {name!r}", (fiber.name for fiber in self.fibers))
        materials = checked_materials(name, self.material, self.materials, mesh.tets, regions)
        checks.keep(self, materials=MappingProxyType(materials))
        for region in (*(law.region for law in self.directional_friction), *materials):
            self.region(region)

    @classmethod
    def from_surface(
        cls,
        surface: str | Path | TetMesh | Skin | trimesh.Trimesh,
        *,
        name: str | None = None,
        unit: str | float | None = None,
        height: float | None = None,
        up: str | None = None,
        forward: str | None = None,
        repair: str = "auto",
        tets: int | None = None,
        density: float = 1000.0,
        on_floor: bool = True,
    ) -> Character:
        """Make a character of a surface: tets, regions, muscles and a material that stands.

        Flawed surfaces are taken: parts are united, holes closed and parts that are inside out
        turned, and a `MeshWarning` says so. The same surface gives the same character. Its regions
        are `base`, `foot_0`, ..., `head`, `limb_0`, ... (docs/own-character.md); four longitudinal
        fibres run along each limb.

        Args:
            surface: a file (.stl, .obj, .ply, .off, .glb, .usd, .usda, .usdc, .usdz), a trimesh
                surface or a skin; or a tet mesh, or its file (.vtu, .msh, ...), which is kept, with
                its regions.
            name: of the character; None for that of the file.
            unit: of the file's lengths: "m", "dm", "cm", "mm", "inch", "foot", or a number of m;
                None for the format's (.glb: m), or m where the body is then from 2 cm to 20 m high.
            height: of the character, m, in place of a unit.
            up: direction that is upwards, such as "y" or "-z"; None for the format's (.glb: y), or
                z.
            forward: direction in which it looks, brought to +x; None for x, or z where up is x.
            repair: "auto", or "none" to refuse a flawed surface.
            tets: about how many, None for 1500; more where its limbs are too thin for so few.
            density: kg/m^3.
            on_floor: put its lowest point on z = 0, what it stands on around x = y = 0, and make
                soles flat that are nearly so.

        Raises:
            MeshError: the surface cannot be read, encloses nothing, or is of parts that do not
                touch.
            InputError: a value out of its range, or a size that is hardly meant.
        """
        # few need it, and its libraries take long to load
        from warp_softbody.body.making.from_surface import made_from_surface

        made = made_from_surface(
            surface,
            name=name,
            unit=unit,
            height=height,
            up=up,
            forward=forward,
            repair=repair,
            tets=tets,
            density=density,
            stand=on_floor,
        )
        return cls(**made.parts)

    def __repr__(self) -> str:
        """Name and numbers; `Character.regions` and the like have the rest."""
        return (
            f"Character(name={self.name!r}, nodes={len(self.mesh.points)}, "
            f"tets={len(self.mesh.tets)}, segments={self.segment_count}, "
            f"regions={len(self.regions)})"
        )

    def save(self, path: str | Path) -> None:
        """Write the character to a file that ends in .char, whole or not at all.

        Raises:
            InputError: the path is none, or has another ending.
            OutputError: the file cannot be written.
        """
        save_character(self, input_kinds.path("path of Character.save", path))

    @classmethod
    def load(cls, path: str | Path) -> Character:
        """Read a character that `save` wrote; nothing that a file holds is run.

        Raises:
            InputError: the file is missing, is no character's, or holds what no character can have.
        """
        file = input_kinds.path("path of Character.load", path)
        parts = load_character(file)
        try:
            return cls(**parts)
        except InputError as error:
            raise InputError(f"{file}: {error}") from error

    @property
    def fibers(self) -> tuple[Fiber, ...]:
        """Fibres of all groups, in the order of the model's segments."""
        return tuple(fiber for group in self.muscles for fiber in group.fibers)

    @property
    def segment_count(self) -> int:
        """Number of muscle segments of all groups."""
        return sum(group.segment_count for group in self.muscles)

    @cached_property
    def tet_materials(self) -> TetMaterials:
        """Return how stiff and dense each tet is."""
        mesh = self.mesh
        return tet_materials(
            mesh.tets, len(mesh.points), self.material, self.materials, self.regions
        )

    @cached_property
    def node_masses(self) -> FloatArray:
        """Return the masses (n,) of the nodes, kg: of each tet a quarter at each of its corners."""
        mesh, count = self.mesh, len(self.mesh.points)
        if self.materials:
            return lumped_masses(mesh.tets, mesh.volumes * self.tet_materials.densities, count)
        return lumped_masses(mesh.tets, mesh.volumes, count, self.material.density)

    @cached_property
    def node_friction(self) -> NodeFriction:
        """Return the directional friction of each node."""
        return friction_by_node(self.directional_friction, self.regions, len(self.mesh.points))

    @cached_property
    def skin_weights(self) -> csr_array[np.float64]:
        """Return the barycentric weights (k, nodes) of the skin's points.

        Raises:
            InputError: there is no skin, or it lies too far outside the tets.
        """
        if self.skin is None:
            raise InputError(f"character {self.name!r} has no skin")
        return bind(self.mesh, self.skin.points, f"skin of {self.name!r}")

    def region(self, name: str) -> IntArray:
        """Return the node indices of a named region, or raise where there is none of that name."""
        if not isinstance(name, str) or name not in self.regions:
            known = ", ".join(sorted(self.regions)) or "none"
            raise InputError(
                f"character {self.name!r} has no region {checks.shown(name)}; it has: {known}"
            )
        return self.regions[name]
