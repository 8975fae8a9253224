"""`TetMesh` is the rest shape of a body: a tetrahedral mesh that never changes."""

from __future__ import annotations

import os
import warnings
from collections.abc import Mapping
from dataclasses import dataclass, field
from functools import cached_property
from pathlib import Path
from typing import TYPE_CHECKING, TypeVar

import numpy as np
import numpy.typing as npt

from warp_softbody.arrays import FloatArray
from warp_softbody.body import mesh_geometry
from warp_softbody.body.mesh_checks import checked_arrays, clean_arrays
from warp_softbody.body.mesh_files import read_tets, write_tets
from warp_softbody.body.skin import READERS, Skin
from warp_softbody.errors import InputError, MeshError, MeshWarning
from warp_softbody.inputs import array_checks, checks, input_kinds
from warp_softbody.inputs.records import FrozenValue

if TYPE_CHECKING:
    import trimesh

IntArray = npt.NDArray[np.int32]
Number = TypeVar("Number", bound=np.generic)


@dataclass(frozen=True, eq=False, repr=False)
class TetMesh(FrozenValue):
    """A tetrahedral mesh in the rest pose, made by `read` or one of the `from_...` methods.

    The constructor itself repairs nothing: it takes arrays such as another mesh's.

    Attributes:
        points: (n, 3) float64 m, read-only; each is a corner of some tet.
        tets: (m, 4) int32, read-only; each of positive volume.
        node_of: (points in the file or array,) int32, read-only; the node that each became, -1
            for a point that was dropped. By default every point is a node.
        regions: node indices (k,) int32 by name, of the named groups of the file.
        skin: the surface that it was made from, where that has a texture; None for none.
    """

    points: FloatArray
    tets: IntArray
    node_of: IntArray = field(default_factory=lambda: np.zeros(0, dtype=np.int32), repr=False)
    regions: Mapping[str, IntArray] = field(default_factory=dict, repr=False)
    skin: Skin | None = field(default=None, repr=False)

    def __post_init__(self) -> None:
        """Keep read-only copies of arrays that can be a mesh's."""
        points, tets = checked_arrays(self.points, self.tets, source="TetMesh")
        node_of = array_checks.array("TetMesh.node_of", self.node_of, (None,))
        if not len(node_of):
            node_of = np.arange(len(points), dtype=np.float64)
        whole = (node_of >= -1) & (node_of < len(points)) & (node_of == np.floor(node_of))
        if not whole.all():
            raise InputError(
                f"TetMesh.node_of must hold nodes from 0 to {len(points) - 1}, or -1 for none, "
                f"but it holds {node_of[~whole][0]:g}"
            )
        regions = {
            name: _frozen(input_kinds.node_set(f"region {name!r} of a TetMesh", nodes, len(points)))
            for name, nodes in input_kinds.mapping("TetMesh.regions", self.regions).items()
        }
        checks.keep(
            self,
            skin=None if self.skin is None else checks.instance("TetMesh.skin", self.skin, Skin),
            points=_frozen(points),
            tets=_frozen(tets),
            node_of=_frozen(node_of.astype(np.int32)),
            regions=regions,
        )
        wrong = np.flatnonzero(~(self.volumes > 0.0))
        if wrong.size:
            raise MeshError(
                f"TetMesh: tet {wrong[0]} has a volume of {self.volumes[wrong[0]]:.3g} m^3, but it "
                "must be positive; TetMesh.from_arrays turns tets round"
            )

    @classmethod
    def from_arrays(
        cls,
        points: npt.ArrayLike,
        tets: npt.ArrayLike,
        *,
        source: str = "arrays",
        allow_parts: bool = False,
    ) -> TetMesh:
        """Make a mesh of checked arrays.

        Tets of negative volume are turned round, points within 1e-9 of the box's diagonal are
        merged, and points that no tet uses are dropped. Both shift the numbers of other points: a
        `MeshWarning` says so, `node_of` and `nodes_of` map the given numbers to nodes.

        Args:
            points: (n, 3) m.
            tets: (m, 4) point indices.
            source: what the sentences of the errors call these arrays, such as a file name.
            allow_parts: accept a mesh of several separate parts.

        Raises:
            MeshError: what is wrong, naming the source, the field and the value.
        """
        input_kinds.name("source of TetMesh.from_arrays", source)
        checks.truth("allow_parts of TetMesh.from_arrays", allow_parts)
        clean = clean_arrays(points, tets, source=source, allow_parts=allow_parts)
        _tell(clean.notes)
        return cls(clean.points, clean.tets, clean.node_of)

    @classmethod
    def read(cls, path: str | Path, *, allow_parts: bool = False) -> TetMesh:
        """Read the linear tets of any file that meshio reads (.vtu, .vtk, .msh, .mesh, ...).

        Named groups of the file become `regions`. A `MeshWarning` says what else is in the file and
        was left out: other cells, points that no tet uses, cells whose numbers are missing.

        Raises:
            MeshError: the file is missing, unreadable, without tets, holds less than it declares,
                or its mesh is refused.
        """
        file = input_kinds.path("path of TetMesh.read", path)
        found = read_tets(file)
        clean = clean_arrays(found.points, found.tets, source=str(path), allow_parts=allow_parts)
        _tell((*found.notes, *clean.notes))
        regions = {name: clean.node_of[points] for name, points in found.groups.items()}
        in_mesh = {name: nodes[nodes >= 0] for name, nodes in regions.items()}
        return cls(clean.points, clean.tets, clean.node_of, in_mesh)

    @classmethod
    def from_surface(
        cls,
        surface: str | Path | trimesh.Trimesh,
        *,
        mesher: str = "ftetwild",
        size: float | None = None,
    ) -> TetMesh:
        """Fill a closed surface with tets and compare the result with it.

        A file with texture coordinates becomes the mesh's `skin`.

        Args:
            surface: a file (.stl, .obj, .ply) or a trimesh surface.
            mesher: "ftetwild" (takes flawed surfaces, follows them closely but not exactly) or
                "tetgen" (exact and repeatable; needs the extra `tetgen`).
            size: target edge length, m; None for a tenth of the box's diagonal.

        Raises:
            MeshError: the surface is unusable, meshing failed, or the mesh is not the surface's.
            InputError: an unknown mesher or a size that is not positive.
            MissingExtraError: TetGen is asked for but not installed.
        """
        # meshing takes long to load and few need it
        from warp_softbody.body.meshing import tetrahedralize

        if isinstance(surface, str | os.PathLike):
            surface = input_kinds.path("surface of TetMesh.from_surface", surface)
        elif not all(hasattr(surface, name) for name in ("vertices", "faces", "merge_vertices")):
            checks.refuse("surface of TetMesh.from_surface", "a file or a trimesh.Trimesh", surface)
        filled = tetrahedralize(surface, mesher=mesher, size=size)
        return cls(filled.points, filled.tets, skin=_texture_of(surface))

    def write(self, path: str | Path) -> None:
        """Write the tets in the format of the file's extension, whole or not at all.

        Regions are not written, and a `MeshWarning` says so.

        Raises:
            InputError: the path is no path.
            OutputError: an extension that cannot be written, or a folder that cannot.
        """
        write_tets(input_kinds.path("path of TetMesh.write", path), self.points, self.tets)
        if self.regions:
            _tell((f"{path}: the regions {', '.join(self.regions)} are not written",))

    @cached_property
    def file_nodes(self) -> npt.NDArray[np.int64]:
        """Number (n,) in the file or array, from 0, of the first point that became each node."""
        nodes, first = np.unique(self.node_of, return_index=True)
        return _frozen(first[nodes >= 0].astype(np.int64))

    def nodes_of(self, numbers: npt.ArrayLike) -> IntArray:
        """Nodes (k,) of points given by their numbers in the file or array, counted from 0.

        `Character(mesh=mesh, fixed=mesh.nodes_of(numbers))` holds the points that the file means.

        Raises:
            MeshError: numbers that are no integers, out of range, or of a point that was dropped.
        """
        try:
            array = np.asarray(numbers)
        except ValueError as error:
            raise MeshError(f"numbers of points are not an array: {error}") from error
        if array.dtype.kind not in "iu" and array.size:
            raise MeshError(f"numbers of points must be integers, got dtype {array.dtype}")
        given = array.astype(np.int64).ravel()
        outside = array.ravel()[(given < 0) | (given >= len(self.node_of))]
        if outside.size:
            raise MeshError(
                f"number {outside[0]} of a point is out of range: {len(self.node_of)} were given"
            )
        nodes = self.node_of[given]
        if (nodes < 0).any():
            raise MeshError(f"point {given[nodes < 0][0]} is in no tet, so that no node is of it")
        return nodes

    @cached_property
    def surface(self) -> IntArray:
        """Outward triangles (f, 3) int32 of the surface, as point indices."""
        return _frozen(mesh_geometry.surface_triangles(self.tets))

    @cached_property
    def surface_nodes(self) -> IntArray:
        """Ascending point indices (k,) int32 that the surface uses."""
        return _frozen(np.unique(self.surface).astype(np.int32))

    @cached_property
    def volumes(self) -> FloatArray:
        """Volumes (m,) of the tets, m^3, all positive."""
        return _frozen(mesh_geometry.tet_volumes(self.points, self.tets))

    @cached_property
    def volume(self) -> float:
        """Volume of the body, m^3."""
        return float(self.volumes.sum())

    @cached_property
    def smallest_dihedral_angle(self) -> float:
        """Smallest angle between two faces of one tet, degrees; 70.5 is the best there is."""
        return float(mesh_geometry.dihedral_angles(self.points, self.tets).min())

    @cached_property
    def bounds(self) -> FloatArray:
        """Lowest and highest corner (2, 3) of the box around the points, m."""
        return _frozen(np.stack([self.points.min(axis=0), self.points.max(axis=0)]))

    @cached_property
    def part_count(self) -> int:
        """Number of parts that hang together through shared faces."""
        return mesh_geometry.count_parts(self.tets)


def _tell(notes: tuple[str, ...]) -> None:
    """Warn, on behalf of the caller of `from_arrays` or `read`."""
    for note in notes:
        warnings.warn(note, MeshWarning, stacklevel=3)


def _frozen(array: npt.NDArray[Number]) -> npt.NDArray[Number]:
    array.setflags(write=False)
    return array


def _texture_of(surface: object) -> Skin | None:
    """The surface of a file as a skin, where it has texture coordinates."""
    if not isinstance(surface, Path) or surface.suffix.lower() not in READERS:
        return None
    skin = Skin.read(surface)
    return skin if skin.textured else None
