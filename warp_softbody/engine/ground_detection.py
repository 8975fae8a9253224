"""The contact planes of the surface nodes on a ground, with one kernel for each kind of ground."""

from __future__ import annotations

from typing import Any, Protocol

import numpy as np
import warp as wp

from warp_softbody.device.launching import launch
from warp_softbody.device.structs import struct_of
from warp_softbody.engine.model import Model
from warp_softbody.engine.state import State
from warp_softbody.errors import InputError
from warp_softbody.kernels.contact.ground_heights import make_ground_heights
from warp_softbody.kernels.contact.ground_plane import make_ground_plane
from warp_softbody.kernels.contact.ground_triangles import make_ground_triangles
from warp_softbody.world.ground import Plane
from warp_softbody.world.height_field import HeightField
from warp_softbody.world.triangle_ground import TriangleGround


class Detection(Protocol):
    """Finds where the surface nodes of a model stand to its ground; made to be captured."""

    def launch(self, state: State, normal_velocity: Any, normals: Any) -> None:
        """Launch the contact normals of the nodes (n,) and their least normal speeds (contacts,).

        The least speed is -gap / dt, at most the recovery speed.
        """
        ...


def make_detection(model: Model) -> Detection | None:
    """The detection for the ground of a model; None without a ground."""
    ground = model.scene.ground
    if ground is None:
        return None
    if isinstance(ground, Plane):
        return PlaneDetection(model, ground)
    if isinstance(ground, HeightField):
        return HeightDetection(model, ground)
    if isinstance(ground, TriangleGround):
        return TriangleDetection(model, ground)
    raise InputError(f"the engine knows no ground of the type {type(ground).__name__}")


class PlaneDetection:
    """Every node against one plane."""

    def __init__(self, model: Model, plane: Plane) -> None:
        """Keep the plane's numbers on the device."""
        kernels = make_ground_plane(model.options.precision)
        self._model = model
        self._kernel = kernels.detect
        self._plane = struct_of(
            kernels.GroundPlane,
            normal=model.types.vec3(*plane.normal),
            offset=plane.offset,
            recovery_speed=model.recovery_speed,
        )

    def launch(self, state: State, normal_velocity: Any, normals: Any) -> None:
        """See `Detection`."""
        m, a = self._model, self._model.arrays
        inputs = [a.mesh.surface_nodes, self._plane, a.step.factors, state.positions]
        _launch(m, self._kernel, inputs, [normal_velocity, normals])


class HeightDetection:
    """Every node against the triangle below it, or below where it is about to be."""

    def __init__(self, model: Model, ground: HeightField) -> None:
        """Keep the grid on the device."""
        kernels = make_ground_heights(model.options.precision)
        self._model = model
        self._kernel = kernels.detect
        self._grid = struct_of(
            kernels.HeightGrid,
            heights=model.array(ground.heights, model.types.scalar),
            origin_x=ground.origin[0],
            origin_y=ground.origin[1],
            spacing_x=ground.spacing[0],
            spacing_y=ground.spacing[1],
            recovery_speed=model.recovery_speed,
        )

    def launch(self, state: State, normal_velocity: Any, normals: Any) -> None:
        """See `Detection`."""
        m, a = self._model, self._model.arrays
        inputs = [a.mesh.surface_nodes, self._grid, a.step.factors]
        inputs += [state.positions, state.velocities]
        _launch(m, self._kernel, inputs, [normal_velocity, normals])


class TriangleDetection:
    """Every node against the closest point of a mesh."""

    def __init__(self, model: Model, ground: TriangleGround) -> None:
        """Build the search tree and keep the features' normals on the device."""
        kernels = make_ground_triangles(model.options.precision)
        self._model = model
        self._kernel = kernels.detect
        self._tree = ground.tree_on(model.options.device)
        # a node deeper than the body is large has gone through
        size = float(np.linalg.norm(np.ptp(model.body.mesh.points, axis=0)))
        self._surface = struct_of(
            kernels.TriangleSurface,
            tree=self._tree.id,
            vertices=model.array(ground.vertices, model.types.vec3),
            faces=model.array(ground.faces, wp.vec3i),
            face_normals=model.array(ground.features.faces, model.types.vec3),
            edge_normals=model.array(ground.features.edges, model.types.vec3),
            vertex_normals=model.array(ground.features.vertices, model.types.vec3),
            reach=size,
        )

    def launch(self, state: State, normal_velocity: Any, normals: Any) -> None:
        """See `Detection`."""
        m, a = self._model, self._model.arrays
        inputs = [a.mesh.surface_nodes, self._surface, float(m.recovery_speed)]
        inputs += [a.step.factors, state.positions]
        _launch(m, self._kernel, inputs, [normal_velocity, normals])


def _launch(model: Model, kernel: Any, inputs: list[Any], outputs: list[Any]) -> None:
    device = model.options.device
    launch(kernel, model.contact_count, inputs, outputs, device)
