"""How a stored mesh was made, in enough detail to make it again."""

from __future__ import annotations

import json
from collections.abc import Mapping
from dataclasses import asdict, dataclass, replace
from typing import TYPE_CHECKING

import numpy as np
import numpy.typing as npt

from warp_softbody.characters.outline import extruded_outline
from warp_softbody.mesh import TetMesh

if TYPE_CHECKING:
    import trimesh

Corners = tuple[tuple[float, float], ...]


@dataclass(frozen=True, kw_only=True)
class Recipe:
    """A letter as one quarter, meshed by TetGen and mirrored in the planes x = 0 and y = 0.

    Mirroring makes the mesh exactly symmetric, so that a body at rest leans to no side.

    Attributes:
        name: the character's name.
        half_outline: corners x, z of the half with x >= 0, m; first and last lie on x = 0.
        depth: extent along y, m.
        size: longest edge of the surface grid, m.
        tetgen_options: keyword arguments of `tetgen.TetGen.tetrahedralize`.
        tetgen_version: version of the tetgen package that made the stored mesh.
        node_count: nodes of the stored mesh.
        tet_count: tets of the stored mesh.
    """

    name: str
    half_outline: Corners
    depth: float
    size: float
    tetgen_options: Mapping[str, object]
    tetgen_version: str
    node_count: int
    tet_count: int

    @classmethod
    def from_json(cls, text: str) -> Recipe:
        """Read what `to_json` wrote."""
        fields = json.loads(text)
        corners = tuple((float(x), float(z)) for x, z in fields.pop("half_outline"))
        return cls(half_outline=corners, **fields)

    def to_json(self) -> str:
        """Text of the stored recipe."""
        return json.dumps(asdict(self), indent=2) + "\n"

    def surface(self) -> trimesh.Trimesh:
        """Closed surface of the whole letter, with nodes mirrored in x and y."""
        right = [(x, z) for x, z in self.half_outline if x > 0.0]
        left = [(-x, z) for x, z in reversed(right)]
        return extruded_outline(right + left, (-0.5 * self.depth, 0.5 * self.depth), self.size)

    def make(self) -> tuple[TetMesh, Recipe]:
        """Make the mesh, and the recipe with the version and counts of this making.

        Raises:
            MissingExtraError: TetGen is not installed.
            MeshError: TetGen failed.
        """
        from warp_softbody.meshing.tetgen_mesher import mesh_with_tetgen, tetgen_version

        quarter = extruded_outline(self.half_outline, (0.0, 0.5 * self.depth), self.size)
        points, tets = mesh_with_tetgen(
            np.array(quarter.vertices),
            np.array(quarter.faces, dtype=np.int32),
            self.tetgen_options,
            source=self.name,
        )
        points, tets = _mirrored(*_mirrored(points, tets, axis=0), axis=1)
        mesh = TetMesh.from_arrays(*_from_ground_up(points, tets), source=self.name)
        made = replace(
            self,
            tetgen_version=tetgen_version() or "unknown",
            node_count=len(mesh.points),
            tet_count=len(mesh.tets),
        )
        return mesh, made


def _mirrored(
    points: npt.NDArray[np.float64], tets: npt.NDArray[np.int32], axis: int
) -> tuple[npt.NDArray[np.float64], npt.NDArray[np.int32]]:
    """Add the mirror image in the plane where a coordinate is zero, sharing the nodes there."""
    on_plane = np.isclose(points[:, axis], 0.0, atol=1e-12)
    points = points.copy()
    points[on_plane, axis] = 0.0
    image = np.where(on_plane, np.arange(len(points)), len(points) + np.cumsum(~on_plane) - 1)
    reflected = points[~on_plane] * np.where(np.arange(3) == axis, -1.0, 1.0)
    # An image in a mirror is turned inside out; two corners change places.
    return np.concatenate([points, reflected]), np.concatenate([tets, image[tets][:, [0, 1, 3, 2]]])


def _from_ground_up(
    points: npt.NDArray[np.float64], tets: npt.NDArray[np.int32]
) -> tuple[npt.NDArray[np.float64], npt.NDArray[np.int32]]:
    """Number nodes and tets by height, so that neighbours stand close together in memory."""
    x, y, z = np.round(points, 9).T
    order = np.lexsort((x, y, z))
    number = np.empty(len(points), dtype=np.int32)
    number[order] = np.arange(len(points), dtype=np.int32)
    tets = number[tets]
    return points[order], tets[np.lexsort(np.sort(tets, axis=1).T[::-1])]
