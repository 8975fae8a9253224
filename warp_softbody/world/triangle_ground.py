"""`TriangleGround` is a fixed ground given by a triangle mesh."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from typing import Any, NamedTuple

import numpy as np
import numpy.typing as npt

from warp_softbody.arrays import FloatArray
from warp_softbody.device.launching import launch
from warp_softbody.device.structs import struct_of
from warp_softbody.device.turns import shares_warp
from warp_softbody.errors import InputError
from warp_softbody.inputs import array_checks, checks
from warp_softbody.inputs.records import FrozenValue
from warp_softbody.world.friction_map import FrictionMap, checked_map
from warp_softbody.world.ground import Vector, measurable

IntArray = npt.NDArray[np.int32]

DOWNWARD = -0.1
"""Area seen from above, over that of all triangles, below which a ground is upside down: closed
surfaces have none, tunnels little."""


class FeatureNormals(NamedTuple):
    """Outward unit normals: of faces (f, 3), of the edge opposite each corner (f, 3, 3), (v, 3)."""

    faces: FloatArray
    edges: FloatArray
    vertices: FloatArray


@dataclass(frozen=True, kw_only=True, eq=False, repr=False)
class TriangleGround(FrozenValue):
    """A fixed ground given by triangles; open meshes have a front and a back.

    Attributes:
        vertices: (v, 3) m.
        faces: (f, 3) vertex indices, counter-clockwise seen from outside.
        friction: Coulomb coefficient mu, >= 0.
        normal: unit direction that counts as up on it as a whole.
        friction_map: factors on the friction by place; None where it is the same everywhere.
    """

    vertices: FloatArray
    faces: IntArray
    friction: float = 0.8
    normal: Vector = (0.0, 0.0, 1.0)
    friction_map: FrictionMap | None = None

    def __post_init__(self) -> None:
        """Check shapes, indices and areas; keep own copies."""
        friction = checks.number("TriangleGround.friction", self.friction, low=0.0)
        x, y, z = checks.direction("TriangleGround.normal", self.normal)
        given = checked_map("TriangleGround.friction_map", self.friction_map)
        checks.keep(self, friction=friction, normal=(x, y, z), friction_map=given)
        label = "TriangleGround.vertices"
        vertices = np.array(array_checks.array(label, self.vertices, (None, 3), unit="m"))
        corners = array_checks.array("TriangleGround.faces", self.faces, (None, 3))
        if not len(corners):
            raise InputError("TriangleGround.faces must hold at least one triangle")
        outside = ~((corners >= 0) & (corners < len(vertices)) & (corners == np.floor(corners)))
        if outside.any():
            raise InputError(
                f"TriangleGround.faces holds the corner {corners[outside][0]:g} outside its "
                f"{len(vertices)} vertices"
            )
        faces = corners.astype(np.int32)
        flat = np.flatnonzero(np.linalg.norm(_crossed(vertices, faces), axis=1) == 0.0)
        if len(flat):
            raise InputError(f"triangle {flat[0]} of the ground has no area")
        self._refuse_upside_down(_crossed(vertices, faces))
        for array, name in ((vertices, "vertices"), (faces, "faces")):
            array.setflags(write=False)
            checks.keep(self, **{name: array})

    def _refuse_upside_down(self, crossed: FloatArray) -> None:
        """Refuse a surface whose outside is below: bodies would fall through it without a word."""
        seen, area = float((crossed @ self.normal).sum()), np.linalg.norm(crossed, axis=1).sum()
        if seen < DOWNWARD * area:
            raise InputError(
                "TriangleGround.faces run clockwise seen from where TriangleGround.normal points, "
                "so the ground's outside is below it; name the corners of each triangle in the "
                "other order (faces[:, ::-1])"
            )

    @cached_property
    def features(self) -> FeatureNormals:
        """Normals of all features; those of edges are means of the faces that share them."""
        crossed = _crossed(self.vertices, self.faces)
        normals = _unit(crossed)
        pairs = np.sort(self.faces[:, [[1, 2], [2, 0], [0, 1]]].reshape(-1, 2), axis=1)
        _, edge = np.unique(pairs, axis=0, return_inverse=True)
        sums = np.zeros((edge.max() + 1, 3))
        np.add.at(sums, edge.ravel(), np.repeat(normals, 3, axis=0))
        corners = self.vertices[self.faces]
        ahead = _unit(np.roll(corners, -1, axis=1) - corners)
        behind = _unit(np.roll(corners, 1, axis=1) - corners)
        angles = np.arccos(np.clip((ahead * behind).sum(axis=2), -1.0, 1.0))
        at_vertices = np.zeros_like(self.vertices)
        np.add.at(at_vertices, self.faces, angles[:, :, None] * normals[:, None, :])
        edges = _unit(sums)[edge.ravel()].reshape(-1, 3, 3)
        return FeatureNormals(normals, edges, _unit(at_vertices))

    @cached_property
    def tree(self) -> Any:
        """Warp's search tree over the triangles, on the CPU."""
        return self.tree_on("cpu")

    @shares_warp
    def tree_on(self, device: str) -> Any:
        """A search tree on a device."""
        # here and not above, so that describing a scene does not start Warp
        import warp as wp

        from warp_softbody.device.warp_runtime import start

        start()
        points: Any = wp.array(self.vertices.astype(np.float32), dtype=wp.vec3, device=device)
        return wp.Mesh(points, wp.array(self.faces.ravel(), dtype=wp.int32, device=device))

    @shares_warp
    def measure(self, points: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Signed distances (k,) m to the closest points of the mesh, and normals (k, 3)."""
        import warp as wp

        from warp_softbody.device.warp_runtime import start, with_kernels
        from warp_softbody.kernels.contact.ground_triangles import make_ground_triangles

        start()

        points = measurable("points of TriangleGround.measure", points)
        features = self.features
        found: Any = wp.zeros(len(points), dtype=wp.vec4d, device="cpu")
        far = float(np.ptp(np.concatenate([self.vertices, points]), axis=0).sum())
        kernels = make_ground_triangles("float64")
        surface = struct_of(
            kernels.TriangleSurface,
            tree=self.tree.id,
            vertices=wp.array(self.vertices, dtype=wp.vec3d, device="cpu"),
            faces=wp.array(self.faces, dtype=wp.vec3i, device="cpu"),
            face_normals=wp.array(features.faces, dtype=wp.vec3d, device="cpu"),
            edge_normals=wp.array(features.edges, dtype=wp.vec3d, device="cpu"),
            vertex_normals=wp.array(features.vertices, dtype=wp.vec3d, device="cpu"),
            reach=far,
        )
        points = np.ascontiguousarray(points)
        inputs = [surface, wp.array(points, dtype=wp.vec3d, device="cpu")]
        with_kernels(lambda: launch(kernels.measure, len(points), inputs, [found], "cpu"))
        normals_and_gaps = found.numpy()
        return normals_and_gaps[:, 3].copy(), normals_and_gaps[:, :3].copy()

    def triangles(self) -> tuple[FloatArray, IntArray]:
        """Vertices (v, 3) m and faces (f, 3)."""
        return self.vertices, self.faces


def _crossed(vertices: FloatArray, faces: IntArray) -> FloatArray:
    a, b, c = (vertices[faces[:, k]] for k in range(3))
    return np.asarray(np.cross(b - a, c - a))


def _unit(vectors: FloatArray) -> FloatArray:
    """Unit vectors; zero stays zero, as where the faces at an edge are back to back."""
    lengths = np.linalg.norm(vectors, axis=-1, keepdims=True)
    return np.asarray(np.divide(vectors, lengths, out=np.zeros_like(vectors), where=lengths > 0.0))
