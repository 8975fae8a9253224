"""A `Recipe` records how a stored mesh was made, in enough detail to make it again."""

from __future__ import annotations

import json
from collections.abc import Mapping
from dataclasses import asdict, dataclass, field, replace
from typing import TYPE_CHECKING

import numpy as np
import numpy.typing as npt

from warp_softbody.arrays import FloatArray
from warp_softbody.body.mesh import TetMesh
from warp_softbody.characters.outline import extruded_outline

if TYPE_CHECKING:
    import trimesh

Cells = npt.NDArray[np.int32]
Corners = tuple[tuple[float, float], ...]

AXES = "xyz"


@dataclass(frozen=True, kw_only=True)
class Recipe:
    """A letter as one part, meshed by TetGen and mirrored in planes where a coordinate is zero.

    Mirroring makes the mesh exactly symmetric, so that a body at rest leans to no side. A standing
    letter is drawn in the x-z plane and reaches from y = -depth / 2 to depth / 2; a lying one is
    drawn in the x-y plane and reaches from z = 0 to depth. At last it is put on z = 0.

    Attributes:
        name: the character's name.
        outline: corners of the part in the plane of the drawing, m; coordinates that are mirrored
            are not negative.
        depth: thickness of the whole letter, m.
        size: longest edge of the surface grid, m.
        mirrors: axes of the mirrors, in order; a standing letter has y among them.
        lying: whether the letter lies on the ground.
        arch: how far, m, a lying letter is lifted at distances (|x| + |y|) / sqrt(2) from its
            middle, m: corners of a polyline; empty for a flat one.
        tetgen_options: keyword arguments of `tetgen.TetGen.tetrahedralize`.
        tetgen_version: version of the tetgen package that made the stored mesh.
        node_count: nodes of the stored mesh.
        tet_count: tets of the stored mesh.
    """

    name: str
    outline: Corners
    depth: float
    size: float
    mirrors: str = "xy"
    lying: bool = False
    arch: Corners = ()
    tetgen_options: Mapping[str, object] = field(
        default_factory=lambda: {"nobisect": True, "mindihedral": 10.0, "minratio": 1.2}
    )
    tetgen_version: str = ""
    node_count: int = 0
    tet_count: int = 0

    @classmethod
    def from_json(cls, text: str) -> Recipe:
        """Read what `to_json` wrote."""
        fields = json.loads(text)
        for name in ("outline", "arch"):
            fields[name] = tuple((float(a), float(b)) for a, b in fields[name])
        return cls(**fields)

    def to_json(self) -> str:
        """Text of the stored recipe."""
        return json.dumps(asdict(self), indent=2) + "\n"

    @property
    def drawing(self) -> Recipe:
        """The recipe without what is only known after making it."""
        return replace(self, tetgen_version="", node_count=0, tet_count=0)

    @property
    def volume(self) -> float:
        """Volume of the extruded letter, m^3: lifting by an arch does not change it."""
        x, z = np.array(self.outline).T
        area = 0.5 * abs(float(x @ np.roll(z, -1) - z @ np.roll(x, -1)))
        in_drawing = "xy" if self.lying else "xz"
        parts = 2.0 ** sum(axis in in_drawing for axis in self.mirrors)
        return parts * area * self.depth

    def lift(self, distance: npt.ArrayLike) -> FloatArray:
        """Height in m of the underside at distances (|x| + |y|) / sqrt(2) from the middle, m."""
        known = np.array(self.arch or [(0.0, 0.0)])
        values = np.asarray(distance, dtype=np.float64)
        return np.asarray(np.interp(values, known[:, 0], known[:, 1]))

    def surface(self) -> trimesh.Trimesh:
        """Closed surface of the whole letter, mirrored as the mesh is."""
        import trimesh

        points, faces = self._part()
        for axis in map(AXES.index, self.mirrors):
            within = np.isclose(points[faces][:, :, axis], 0.0, atol=1e-12).all(axis=1)
            points, faces = _mirrored(points, faces[~within], axis)
        surface = trimesh.Trimesh(vertices=_grounded(points), faces=faces, process=False)
        surface.remove_unreferenced_vertices()
        return surface

    def make(self) -> tuple[TetMesh, Recipe]:
        """Make the mesh, and the recipe with the version and counts of this making.

        Raises:
            MissingExtraError: TetGen is not installed.
            MeshError: TetGen failed.
        """
        from warp_softbody.body.meshing.tetgen_mesher import mesh_with_tetgen, tetgen_version

        points, tets = mesh_with_tetgen(*self._part(), dict(self.tetgen_options), source=self.name)
        for axis in map(AXES.index, self.mirrors):
            points, tets = _mirrored(points, tets, axis)
        mesh = TetMesh.from_arrays(*_from_ground_up(_grounded(points), tets), source=self.name)
        made = replace(
            self,
            tetgen_version=tetgen_version() or "unknown",
            node_count=len(mesh.points),
            tet_count=len(mesh.tets),
        )
        return mesh, made

    def _part(self) -> tuple[FloatArray, Cells]:
        """Points (n, 3) m and outward triangles (f, 3) of the part that is mirrored."""
        reach = self.depth if self.lying else 0.5 * self.depth
        part = extruded_outline(self.outline, (0.0, reach), self.size)
        points, faces = np.array(part.vertices), np.array(part.faces, dtype=np.int32)
        if not self.lying:
            return points, faces
        x, z, y = points.T
        lifted = z + self.lift((np.abs(x) + np.abs(y)) / np.sqrt(2.0))
        # Two coordinates change places, which turns the surface inside out.
        return np.stack([x, y, lifted], axis=1), faces[:, ::-1].copy()


def _mirrored(points: FloatArray, cells: Cells, axis: int) -> tuple[FloatArray, Cells]:
    """Add the mirror image in the plane where a coordinate is zero, sharing the nodes there."""
    on_plane = np.isclose(points[:, axis], 0.0, atol=1e-12)
    points = points.copy()
    points[on_plane, axis] = 0.0
    image = np.where(on_plane, np.arange(len(points)), len(points) + np.cumsum(~on_plane) - 1)
    reflected = points[~on_plane] * np.where(np.arange(3) == axis, -1.0, 1.0)
    # An image in a mirror is turned inside out; two corners change places.
    turned = image[cells]
    turned[:, [-2, -1]] = turned[:, [-1, -2]]
    return np.concatenate([points, reflected]), np.concatenate([cells, turned])


def _grounded(points: FloatArray) -> FloatArray:
    """Points moved along z, so that the lowest is at zero."""
    return np.asarray(points - np.array([0.0, 0.0, points[:, 2].min()]))


def _from_ground_up(points: FloatArray, tets: Cells) -> tuple[FloatArray, Cells]:
    """Number nodes and tets by height, so that neighbours stand close together in memory."""
    x, y, z = np.round(points, 9).T
    order = np.lexsort((x, y, z))
    number = np.empty(len(points), dtype=np.int32)
    number[order] = np.arange(len(points), dtype=np.int32)
    tets = number[tets]
    return points[order], tets[np.lexsort(np.sort(tets, axis=1).T[::-1])]
