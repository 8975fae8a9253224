"""Finds where sharp edges of the ground meet a body between its nodes."""

from __future__ import annotations

from typing import Any

import numpy as np
import warp as wp

from warp_softbody.body.surface_edges import SurfaceEdges
from warp_softbody.device.launching import launch
from warp_softbody.device.structs import struct_of
from warp_softbody.device.warp_runtime import captured
from warp_softbody.engine.contact_arrays import FoundPairs
from warp_softbody.engine.model import Model
from warp_softbody.engine.placed_friction import PlacedFriction
from warp_softbody.engine.state import PairStates, State
from warp_softbody.kernels.contact.ground_edges import make_ground_edges
from warp_softbody.kernels.contact.ground_heights import make_ground_heights
from warp_softbody.kernels.contact.pair_thinning import make_pair_thinning
from warp_softbody.kernels.contact.structs import make_pair_structs
from warp_softbody.world.height_field import HeightField


class GroundEdges:
    """Edges of the bodies' surfaces across those of a height field."""

    def __init__(self, model: Model, found: FoundPairs, friction: float) -> None:
        """Keep the edges on the device.

        Args:
            model: whose ground is a height field with sharp edges.
            found: is what is written.
            friction: by which the kernels of pairs multiply factors of friction.
        """
        ground = model.scene.ground
        assert isinstance(ground, HeightField) and model.arrays.ground is not None
        precision, types = model.options.precision, model.types
        self._model, self._found = model, found
        self._structs = make_pair_structs(precision)
        self._kernels = make_ground_edges(precision)
        self._list = make_pair_thinning(precision).list_found
        self._placed = PlacedFriction.of(model)
        self._first = PairStates.first_on_ground(model)
        self._graphs: dict[tuple[int, int], Any] = {}
        self._edges, self._count = self._body_edges()
        grid = struct_of(
            make_ground_heights(precision).HeightGrid,
            heights=model.array(ground.heights, types.scalar),
            origin_x=ground.origin[0],
            origin_y=ground.origin[1],
            spacing_x=ground.spacing[0],
            spacing_y=ground.spacing[1],
            recovery_speed=model.recovery_speed,
        )
        self._creases = struct_of(
            self._kernels.Creases,
            grid=grid,
            flags=model.array(ground.creases, wp.int32),
            rows=model.array(ground.creases.any(axis=1).astype(np.int32), wp.int32),
        )
        coefficients = model.arrays.ground.friction
        self._coefficients = coefficients if self._placed is None else self._placed.coefficients
        self._factors = model.array(self._least_factors(friction), types.scalar)

    def _body_edges(self) -> tuple[Any, int]:
        """The struct of the edges of all bodies, and their number."""
        model, mesh = self._model, self._model.body.mesh
        found = SurfaceEdges.of(mesh.surface)
        slots = np.full(model.node_count, -1, dtype=np.int32)
        slots[mesh.surface_nodes] = np.arange(len(mesh.surface_nodes))
        edges = struct_of(
            self._kernels.BodyEdges,
            ends=model.array(found.ends, wp.vec2i),
            left=model.array(mesh.surface[found.faces[:, 0]], wp.vec3i),
            right=model.array(mesh.surface[found.faces[:, 1]], wp.vec3i),
            opposite=model.array(found.opposite, wp.vec2i),
            slots=model.array(slots, wp.int32),
        )
        return edges, len(found.ends)

    def _least_factors(self, friction: float) -> Any:
        """(c,) what coefficients of the nodes are multiplied with: edges know no directions.

        Where friction hangs on the direction, it is the least one.
        """
        body = self._model.body
        nodes = body.mesh.surface_nodes
        least = np.ones(len(nodes))
        if body.directional_friction:
            least = body.node_friction.factors[nodes].min(axis=1)
        return least / friction if friction > 0.0 else 0.0 * least

    def find(self, state: State, pairs: PairStates) -> None:
        """Find the crossings of a step that starts from ``state``, and list all pairs anew."""
        key = (id(state), id(pairs))
        if key not in self._graphs:
            device = self._model.options.device
            graph = captured(device, lambda: self._launch_search(state, pairs))
            # the states are kept alive, so that their identities are not used again
            self._graphs[key] = (graph, state, pairs)
        wp.capture_launch(self._graphs[key][0])

    def _launch_search(self, state: State, states: PairStates) -> None:
        model = self._model
        if self._placed is not None:
            self._placed.launch(state)
        pairs = struct_of(
            self._structs.Pairs, self._found, nodes=states.nodes, weights=states.weights
        )
        inputs = [self._edges, self._creases, self._coefficients, self._factors]
        inputs += [model.arrays.step.factors, self._first, state.positions, state.velocities]
        device = model.options.device
        launch(self._kernels.cross_creases, self._count, inputs, [pairs], device)
        launch(self._list, 1, [], [pairs, states.modes], device)
