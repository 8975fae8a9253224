"""Contact of surfaces with each other: between bodies, and of a body with itself."""

from __future__ import annotations

from typing import Any

import numpy as np
import numpy.typing as npt
import warp as wp

from warp_softbody.kernels.pair_detection import make_pair_detection
from warp_softbody.kernels.pair_modes import make_pair_modes
from warp_softbody.kernels.pair_rows import make_pair_rows
from warp_softbody.model import Model
from warp_softbody.state import PairStates, State
from warp_softbody.topology import starts
from warp_softbody.warp_runtime import with_kernels

IntArray = npt.NDArray[np.int32]


DEEPEST = 1.0
"""Part of an edge's length by which a node may be inside of a body and find its way out; bodies may
be placed so."""

DEEPEST_OF_ITSELF = 0.3
"""The same where a body can only touch itself, which it does not do at the start."""


def mean_edge(points: npt.NDArray[np.float64], surface: IntArray) -> float:
    """Mean length of the edges of triangles, m."""
    corners = points[surface]
    return float(np.linalg.norm(corners - np.roll(corners, 1, axis=1), axis=2).mean())


class PairDetection:
    """Finds for every surface node the triangle that it may touch in a step.

    The search tree follows the surface; it is refitted outside of captured graphs, which do not
    record that.
    """

    def __init__(self, model: Model) -> None:
        """Build the search tree over the surfaces of all bodies."""
        types, mesh, scene = model.types, model.body.mesh, model.scene
        self._model = model
        self._kernels = make_pair_detection(model.options.precision)
        surface = mesh.surface
        owners = surface.ravel()
        order = np.argsort(owners, kind="stable")
        fan = starts(owners[order], model.node_count)
        fan_start = np.append(fan[mesh.surface_nodes], fan[-1])
        body = np.zeros(model.node_count, dtype=np.int32)
        for number, part in enumerate(scene.parts):
            body[part.nodes] = number
        self._points = model.array(mesh.points.astype(np.float32), wp.vec3f)
        self._tree: Any = wp.Mesh(self._points, model.array(owners, wp.int32))
        self._fastest = model.zeros(1, types.scalar)
        slots = np.full(model.node_count, -1, dtype=np.int32)
        slots[mesh.surface_nodes] = np.arange(len(mesh.surface_nodes))
        # the finest body's, so that no search reaches through a body
        edge = min(mean_edge(c.mesh.points, c.mesh.surface) for c in scene.characters)
        nodes, count = model.arrays["surface_nodes"], len(mesh.surface_nodes)
        bodies = model.array(body, wp.int32)
        depth = (DEEPEST if scene.others else DEEPEST_OF_ITSELF) * edge
        lengths = model.array([edge, model.recovery_speed, depth], types.scalar)
        step = model.arrays["step_factors"]
        self._faces = model.array(surface, wp.vec3i)
        self._normals = model.zeros(len(surface), types.vec3)
        self._found = model.zeros(count, wp.vec3i)
        self._gaps = model.zeros(count, types.scalar)
        self._surface = [
            nodes,
            bodies,
            self._tree.id,
            self._faces,
            model.array(fan_start, wp.int32),
            model.array((order // 3).astype(np.int32), wp.int32),
            model.array(mesh.points, types.vec3),
            lengths,
            int(scene.self_contact),
            step,
        ]
        self._sides = [nodes, model.array(slots, wp.int32), bodies, lengths, step]

    def find(self, state: State, pairs: Any, modes: Any) -> None:
        """Corners, weights, normals and least speeds of all pairs, and modes of none."""
        now = [state.positions, state.velocities]
        self._launch(self._kernels.follow, 1, now, [self._points, self._fastest])
        self._tree.refit()
        inputs = [self._faces, state.positions]
        self._launch(self._kernels.find_normals, len(self._faces), inputs, [self._normals])
        inputs = [*self._surface, *now, self._fastest, self._normals]
        outputs = [self._found, pairs.weights, pairs.normals, self._gaps]
        self._launch(self._kernels.detect, len(self._gaps), inputs, outputs)
        inputs = [*self._sides, self._found, pairs.weights, self._gaps]
        outputs = [pairs.corners, pairs.least, modes]
        self._launch(self._kernels.thin_out, len(self._gaps), inputs, outputs)

    def _launch(self, kernel: Any, dim: int, inputs: list[Any], outputs: list[Any]) -> None:
        device = self._model.options.device
        wp.launch(kernel, dim=dim, inputs=inputs, outputs=outputs, device=device)


class PairContact:
    """Rows, projections and modes of pairs; launches are capturable but for `find`."""

    def __init__(self, model: Model, kinds: Any, axes: Any, matrix: Any) -> None:
        """Work arrays; ``kinds`` and ``axes`` are the ground's, ``matrix`` is M~."""
        types, n = model.types, model.node_count
        count = len(model.body.mesh.surface_nodes)
        precision = model.options.precision
        self._model = model
        self._matrix = matrix
        self._rows = make_pair_rows(precision)
        self._modes = make_pair_modes(precision)
        self._detection = PairDetection(model)
        self._pairs = self._rows.Pairs()
        self._pairs.nodes = model.arrays["surface_nodes"]
        self._pairs.corners = model.array(np.full((count, 3), -1, dtype=np.int32), wp.vec3i)
        self._pairs.weights = model.zeros(count, types.vec3)
        self._pairs.normals = model.zeros(count, types.vec3)
        self._pairs.least = model.zeros(count, types.scalar)
        self._pairs.rows = model.zeros(count, wp.int32)
        self._pairs.count = model.zeros(1, wp.int32)
        self._work = self._rows.Work()
        self._work.nodal = model.zeros(n, wp.vec3d)
        for name in "yrpq":
            setattr(self._work, name, model.zeros(count, wp.vec3d))
        self._freedom = self._rows.Freedom()
        self._freedom.kinds, self._freedom.axes = kinds, axes
        self._right = model.zeros(n, types.vec3)
        self._changed = model.zeros(count, wp.int32)
        pair = wp.types.vector(length=2, dtype=types.scalar)
        self._violations = model.zeros(count, pair)
        self._count = count

    def _launch(self, kernel: Any, inputs: list[Any], outputs: list[Any], dim: int = 1) -> None:
        device = self._model.options.device
        wp.launch(kernel, dim=dim, inputs=inputs, outputs=outputs, device=device)

    def find(self, state: State, pairs: PairStates) -> None:
        """The pairs of a step, from where it starts; a node that has none lifts."""
        with_kernels(lambda: self._detection.find(state, self._pairs, pairs.modes))

    @property
    def corners(self) -> Any:
        """(c,) vec3i, the triangle that each surface node may touch; negative for none."""
        return self._pairs.corners

    def _shared(self, pairs: PairStates) -> list[Any]:
        return [self._pairs, pairs.modes, self._freedom, self._work]

    def impose(self, pairs: PairStates, x: Any) -> None:
        """Launch the relative velocities that the modes give."""
        self._launch(self._rows.list_rows, [self._pairs, pairs.modes], [])
        self._launch(self._rows.impose, self._shared(pairs), [x])

    def finish_residual(self, pairs: PairStates, x: Any, r: Any, partial: Any) -> None:
        """Launch r = P (b - matrix x) from the ground's S (b - M~ x)."""
        inputs = [*self._shared(pairs), pairs.slip_stiffness, x]
        self._launch(self._rows.finish_residual, inputs, [r, partial])

    def project(self, pairs: PairStates, v: Any) -> None:
        """Launch v = P v."""
        self._launch(self._rows.project_pairs, self._shared(pairs), [v])

    def finish_product(self, pairs: PairStates, p: Any, q: Any, partial: Any) -> None:
        """Launch q = P matrix p from the ground's S M~ p."""
        inputs = [*self._shared(pairs), pairs.slip_stiffness, p]
        self._launch(self._rows.finish_product, inputs, [q, partial])

    def find_impulses(self, pairs: PairStates, x: Any, right: Any, r: Any) -> Any:
        """Launch the pairs' impulses; the right side with them, as the ground's contacts see it."""
        inputs = [*self._shared(pairs), pairs.friction_forces, pairs.slip_stiffness, x, right]
        self._launch(self._modes.find_impulses, inputs, [r, pairs.impulses, self._right])
        return self._right

    def update(self, pairs: PairStates, x: Any, counters: Any, scalars: Any) -> None:
        """Launch the choice of modes."""
        a = self._model.arrays
        friction = float(self._model.scene.body_friction)
        law = [a["fixed"], a["diagonal_slot"], friction, a["contact_tolerances"]]
        inputs = [*law, self._pairs, self._matrix, x, pairs.impulses, counters, scalars]
        outputs = [pairs.modes, pairs.slip_velocities, pairs.friction_forces]
        outputs += [pairs.slip_stiffness, self._changed, self._violations]
        self._launch(self._modes.update_pairs, inputs, outputs, dim=self._count)

    def add_frictions(
        self, pairs: PairStates, right: Any, ground_frictions: Any, right_with_slip: Any
    ) -> None:
        """Launch the right side with the friction forces of sliding pairs and nodes."""
        inputs = [self._pairs, pairs.modes, pairs.friction_forces, right, ground_frictions]
        self._launch(self._modes.add_frictions, inputs, [right_with_slip])

    def conclude(self, pairs: PairStates, counters: Any, largest_violations: Any) -> None:
        """Launch the count of changes, after the ground's."""
        passes = self._model.options.max_contact_passes
        inputs = [passes, self._changed, pairs.modes, self._violations]
        self._launch(self._modes.conclude_pairs, inputs, [counters, largest_violations])


class PairRows:
    """Pairs with the states of a step, as constraints on its solves."""

    def __init__(self, contact: PairContact, pairs: PairStates, velocities: Any) -> None:
        """Bind the caller's states, and the velocities (n,) vec3 m/s that a solve starts from."""
        self._contact = contact
        self._pairs = pairs
        self._velocities = velocities

    def finish_residual(self, r: Any, partial: Any) -> None:
        """See `Constraints`."""
        self._contact.finish_residual(self._pairs, self._velocities, r, partial)

    def project(self, v: Any) -> None:
        """See `Constraints`."""
        self._contact.project(self._pairs, v)

    def finish_product(self, p: Any, q: Any, partial: Any) -> None:
        """See `Constraints`."""
        self._contact.finish_product(self._pairs, p, q, partial)
