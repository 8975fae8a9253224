"""Finds the pairs of a step: nodes with triangles, and sharp edges across each other."""

from __future__ import annotations

from typing import Any

import numpy as np
import numpy.typing as npt
import warp as wp

from warp_softbody.arrays import FloatArray
from warp_softbody.body.surface_edges import SurfaceEdges
from warp_softbody.device.launching import launch
from warp_softbody.device.structs import struct_of
from warp_softbody.device.warp_runtime import captured
from warp_softbody.engine.contact_arrays import EdgeCandidates, FoundPairs, NodeCandidates
from warp_softbody.engine.model import Model
from warp_softbody.engine.state import PairStates, State
from warp_softbody.kernels.contact.pair_detection import make_pair_detection
from warp_softbody.kernels.contact.pair_edges import make_pair_edges
from warp_softbody.kernels.contact.pair_overlap import make_pair_overlap
from warp_softbody.kernels.contact.pair_surfaces import make_pair_surfaces
from warp_softbody.kernels.contact.pair_thinning import make_pair_thinning
from warp_softbody.kernels.contact.structs import make_pair_structs
from warp_softbody.linear.block_sparsity import starts
from warp_softbody.world.body_overlap import refuse_coincident
from warp_softbody.world.scene import Scene

OBLIQUE = np.array([0.5773, 0.6123, 0.5401])
"""A direction along which bodies are told apart that are alike in everything but their place."""


def mean_edges(points: FloatArray, surface: npt.NDArray[np.integer]) -> FloatArray:
    """(n,) mean length of the sides of the triangles around each node, m; 0 off the surface."""
    corners = points[surface]
    lengths = np.linalg.norm(corners - np.roll(corners, 1, axis=1), axis=2).mean(axis=1)
    owners = surface.ravel()
    total = np.bincount(owners, np.repeat(lengths, 3), minlength=len(points))
    count = np.bincount(owners, minlength=len(points))
    return np.asarray(total / np.maximum(count, 1))


def rank_of(scene: Scene) -> npt.NDArray[np.int32]:
    """(bodies,) place of each body from the finest to the coarsest; order in the scene is no part.

    Bodies whose mean edges agree to a thousandth follow each other by where they stand.
    """
    keys = []
    for body in scene.characters:
        mesh = body.mesh
        corners = mesh.points[mesh.surface]
        edge = np.linalg.norm(corners - np.roll(corners, 1, axis=1), axis=2).mean()
        keys.append((round(1e3 * float(np.log(edge))), float(mesh.points.mean(axis=0) @ OBLIQUE)))
    rank = np.empty(len(keys), dtype=np.int32)
    rank[sorted(range(len(keys)), key=keys.__getitem__)] = np.arange(len(keys))
    return rank


class PairDetection:
    """Finds the pairs of a step, from where it starts.

    The search tree follows the surfaces; it is refitted outside of captured graphs, which do not
    record that.
    """

    def __init__(self, model: Model, found: FoundPairs) -> None:
        """Build the search tree over the surfaces of all bodies; ``found`` is what is written."""
        refuse_coincident(model.scene)
        precision = model.options.precision
        self._model = model
        self._found = found
        self._structs = make_pair_structs(precision)
        self._search = make_pair_surfaces(precision)
        self._detection = make_pair_detection(precision)
        self._overlap = make_pair_overlap(precision)
        self._thinning = make_pair_thinning(precision)
        self._graphs: dict[tuple[int, ...], Any] = {}
        self._expected = model.zeros(model.handled_count, model.types.vec3)
        self._make_surfaces()
        self._make_fans()
        self._make_overlaps()
        count = len(model.body.mesh.surface_nodes)
        nodes = NodeCandidates.of(count, found.normals, model.allocator)
        self._nodes_met = struct_of(self._structs.NodeCandidates, nodes)
        self._crossing = CrossingEdges(model, self._surfaces)

    def _make_surfaces(self) -> None:
        model = self._model
        types, mesh, scene = model.types, model.body.mesh, model.scene
        bodies = len(scene.parts)
        slots = np.full(model.node_count, -1, dtype=np.int32)
        slots[mesh.surface_nodes] = np.arange(len(mesh.surface_nodes))
        self._points = model.array(mesh.points.astype(np.float32), wp.vec3f)
        self._tree: Any = wp.Mesh(self._points, model.array(mesh.surface.ravel(), wp.int32))
        sizes = mean_edges(mesh.points, mesh.surface)[mesh.surface_nodes]
        self._surfaces = struct_of(
            self._search.Surfaces,
            tree=self._tree.id,
            nodes=model.arrays.mesh.surface_nodes,
            slots=model.array(slots, wp.int32),
            sizes=model.array(sizes, types.scalar),
            node_body=model.array(scene.node_bodies, wp.int32),
            fixed=model.arrays.masses.fixed,
            rank=model.array(rank_of(scene), wp.int32),
            faces=model.array(mesh.surface, wp.vec3i),
            face_normals=model.zeros(len(mesh.surface), types.vec3),
            rest=model.array(mesh.points, types.vec3),
            low=model.zeros(bodies, types.vec3),
            high=model.zeros(bodies, types.vec3),
            drift=model.zeros(1, types.vec3),
            fastest=model.zeros(1, types.scalar),
            step_factors=model.arrays.step.factors,
        )
        body_ends = [0, *(part.nodes.stop for part in scene.parts)]
        self._body_start = model.array(np.array(body_ends, dtype=np.int32), wp.int32)

    def _make_fans(self) -> None:
        """The triangles around each surface node."""
        model, mesh = self._model, self._model.body.mesh
        owners = mesh.surface.ravel()
        order = np.argsort(owners, kind="stable")
        fan = starts(owners[order], model.node_count)
        fan_start = np.append(fan[mesh.surface_nodes], fan[-1])
        self._fans = [
            model.array(fan_start, wp.int32),
            model.array((order // 3).astype(np.int32), wp.int32),
        ]

    def _make_overlaps(self) -> None:
        """What bodies that are deep in each other are pushed apart by."""
        model, types = self._model, self._model.types
        bodies = len(model.scene.parts)
        self._overlaps = model.zeros(1, wp.int32)
        self._ways = model.zeros(bodies * bodies, types.vec3)
        self._totals = model.zeros(bodies * bodies, types.scalar)
        self._numbers = model.zeros(bodies * bodies, wp.int32)

    def find(self, state: State, states: PairStates, handled: Any = None) -> None:
        """Find the pairs of a step that starts from ``state``; modes of what has none are lift.

        ``handled`` (n,) vec3 m/s are the velocities of the step that handles give, where there are
        handles.
        """
        s = self._surfaces
        if handled is not None:
            inputs = [s.fixed, handled, state.velocities]
            self._launch(self._search.expect, self._model.node_count, inputs, [self._expected])
        where = [state.positions, self._velocities(state)]
        self._launch(self._search.follow, 1, where, [self._points, s.drift, s.fastest])
        self._tree.refit()
        key = (id(state), id(states))
        if key not in self._graphs:
            device = self._model.options.device
            graph = captured(device, lambda: self._launch_search(state, states))
            # the states are kept alive, so that their identities are not used again
            self._graphs[key] = (graph, state, states)
        wp.capture_launch(self._graphs[key][0])

    def _launch_search(self, state: State, states: PairStates) -> None:
        s, model = self._surfaces, self._model
        x, v, bodies = state.positions, self._velocities(state), len(model.scene.parts)
        self._launch(self._search.find_normals, len(s.faces), [s.faces, x], [s.face_normals])
        self._launch(self._search.find_bounds, bodies, [self._body_start, x], [s.low, s.high])
        inputs = [s, *self._fans, int(model.scene.self_contact), x, v]
        count = len(s.nodes)
        self._launch(self._detection.detect, count, inputs, [self._nodes_met])
        if bodies > 1:
            self._crossing.launch(x, v, self._nodes_met)
            inputs = [s, self._crossing.edges, self._nodes_met, self._crossing.met]
            outputs = [self._ways, self._totals, self._overlaps]
            self._launch(self._overlap.find_ways, 1, inputs, outputs)
            self._crossing.launch_ways(state, self._ways)
        outputs = [self._nodes_met, self._found.friction_factor]
        self._launch(self._overlap.leave, count, [s, x, self._ways], outputs)
        self._launch_thinning(states)

    def _velocities(self, state: State) -> Any:
        """(n,) vec3 m/s with which surfaces are looked for: of handles, those of the step."""
        return self._expected if self._model.scene.handles else state.velocities

    def _launch_thinning(self, states: PairStates) -> None:
        """Launch the choice among the candidates, and the list of the pairs chosen."""
        s, met = self._surfaces, self._nodes_met
        pairs = struct_of(
            self._structs.Pairs, self._found, nodes=states.nodes, weights=states.weights
        )
        # of a pair of bodies, the area that lies in the other, then the spacing of the nodes
        spacing = self._totals
        self._launch(self._thinning.compare, 1, [s, met.corners], [spacing, self._numbers])
        inputs = [s, float(self._model.recovery_speed), spacing, met, states.modes]
        self._launch(self._thinning.thin_nodes, len(s.nodes), inputs, [pairs])
        if len(self._model.scene.parts) > 1:
            self._crossing.launch_thinning(met, states.modes, pairs)
        self._launch(self._thinning.list_found, 1, [], [pairs, states.modes])

    def _launch(self, kernel: Any, dim: int, inputs: list[Any], outputs: list[Any]) -> None:
        device = self._model.options.device
        launch(kernel, dim, inputs, outputs, device)


class CrossingEdges:
    """Finds sharp edges of one body that cross those of another, and edges that lead through one.

    Attributes:
        edges: of all bodies, as the kernels see them.
        met: the struct of their candidates.
    """

    def __init__(self, model: Model, surfaces: Any) -> None:
        """Arrays for the edges of all bodies; none where there is one body."""
        precision = model.options.precision
        self._model = model
        self._surfaces = surfaces
        self._kernels = make_pair_edges(precision)
        self._overlap = make_pair_overlap(precision)
        self._thinning = make_pair_thinning(precision)
        found = SurfaceEdges.of(model.body.mesh.surface)
        count = self._count = len(found.ends) if len(model.scene.parts) > 1 else 0
        self.edges = struct_of(
            self._kernels.Edges,
            ends=model.array(found.ends[:count], wp.vec2i),
            faces=model.array(found.faces[:count], wp.vec2i),
            opposite=model.array(found.opposite[:count], wp.vec2i),
            of_face=model.array(found.of_face, wp.vec3i),
        )
        met = EdgeCandidates.of(count, model.allocator)
        self.met = struct_of(make_pair_structs(precision).EdgeCandidates, met)

    def _launch(self, kernel: Any, dim: int, inputs: list[Any], outputs: list[Any]) -> None:
        device = self._model.options.device
        launch(kernel, dim, inputs, outputs, device)

    def launch(self, positions: Any, velocities: Any, nodes_met: Any) -> None:
        """Launch the search; ``nodes_met`` is the struct of the nodes' candidates."""
        inputs = [self._surfaces, self.edges, positions, velocities]
        self._launch(self._kernels.cross_edges, self._count, inputs, [self.met])
        inputs = [self._surfaces, self.edges, positions, nodes_met]
        self._launch(self._overlap.sink_edges, self._count, inputs, [self.met])

    def launch_ways(self, state: State, ways: Any) -> None:
        """Launch what draws edges out of bodies the given ways."""
        inputs = [self._surfaces, self.edges, state.positions, ways]
        self._launch(self._overlap.draw_out, self._count, inputs, [self.met])

    def launch_thinning(self, nodes_met: Any, modes: Any, pairs: Any) -> None:
        """Launch the choice among the edges' candidates, into the struct ``pairs``."""
        speed = float(self._model.recovery_speed)
        first = len(self._model.body.mesh.surface_nodes)
        inputs = [self._surfaces, self.edges, speed, first, nodes_met, self.met, modes]
        self._launch(self._thinning.thin_edges, 2 * self._count, inputs, [pairs])
