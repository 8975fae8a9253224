"""Muscles that the step's matrix knows: stretches, stiffness and forces of their energy."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np
import warp as wp

from warp_softbody.device.allocator import DeviceArray
from warp_softbody.device.launching import launch
from warp_softbody.device.structs import struct_of
from warp_softbody.device.warp_runtime import with_kernels
from warp_softbody.device.workspace import Workspace
from warp_softbody.engine.model import Model
from warp_softbody.kernels.fiber_blocks import CORNER_PAIRS
from warp_softbody.kernels.fiber_edges import make_fiber_edges
from warp_softbody.kernels.fiber_lanes import fiber_lanes_on
from warp_softbody.kernels.implicit_muscles import make_implicit_muscles

Work = tuple[int, Callable[[int, int], None]]
"""A number of independent items, and what launches those from a first to a last one."""


class ImplicitMuscles:
    """Work arrays of muscles with an energy; launches are capturable (docs/method.md section 2).

    Attributes:
        limits: (s,) scalar m, rest lengths l_d at which segments begin to pull; 0 where a
            controller may choose any.
        lengths: (s,) scalar m, l_0 times the mean stretch.
        reaches: (s,) scalar m, lengths at the step's end of segments that lengthen on as they do.
        deformations: (m,) mat33, F.
        reciprocals: (q,) scalar, 1 / |F d| of the pairs of a tet and a segment.
        rest_rows: (m,) mat33, rows V0 g_a of the corners 1 to 3.
    """

    def __init__(self, model: Model, workspace: Workspace) -> None:
        """Take arrays for a model with muscles out of a workspace."""
        work = workspace.part("implicit muscles", model.allocator)
        types, layout = model.types, model.muscles
        scalar, pairs = types.scalar, len(layout.pair_tet)
        self._model = model
        self._kernels = make_implicit_muscles(model.options.precision)
        options = model.options
        # see `SLOW_ONES`
        self._unturned = 0
        if options.tangent == "conserving":
            self._unturned = 2 if options.newton_iterations == 1 else 1
        kinds = (options.precision, self._kernels.Fibers, self._kernels.FiberState)
        # before any kernel is loaded, as both are of one module
        self._lanes: Any = fiber_lanes_on(options.device, *kinds) if options.native_code else None
        self._edges = self._kernels
        if self._lanes is not None:
            self._edges = make_fiber_edges(options.precision)
        own, mesh = model.arrays.muscles, model.arrays.mesh
        found = (own.pair_weight, own.directions, mesh.rest_inverse, mesh.rest_volume)
        known = workspace.shared("fibers", (), found, lambda: _FiberArrays.of(model))
        self._fibers = struct_of(
            self._kernels.Fibers,
            own,
            tets=mesh.tets,
            rest_inverse=mesh.rest_inverse,
            volume=known.volume,
            share=known.share,
            strength=model.array(layout.stiffness * layout.rest_lengths, scalar),
        )
        self._state = struct_of(
            self._kernels.FiberState,
            deformations=work.zeros(model.tet_count, types.mat33),
            turns=work.zeros(model.tet_count, types.vec3),
            stretches=work.zeros(pairs, scalar),
            rates=work.zeros(pairs, types.vec3),
            speeds=work.zeros(pairs, scalar),
            directions=work.zeros(pairs, types.vec3),
            reciprocals=work.zeros(pairs, scalar),
            moduli=work.zeros(model.segment_count, scalar),
            tensions=work.zeros(model.segment_count, scalar),
        )
        self._segment_pair, self._rest_lengths = known.segment_pair, known.rest_lengths
        self._given_back = model.array(_given_back(model), scalar)
        self._blocks = work.zeros(6 * model.tet_count, types.mat33)
        self._weights, self._sorted = work.zeros(pairs, scalar), work.zeros(pairs, scalar)
        self.limits = work.zeros(model.segment_count, scalar)
        self.lengths = work.zeros(model.segment_count, scalar)
        self.reaches = work.zeros(model.segment_count, scalar)
        self.deformations = self._state.deformations
        self.reciprocals = self._state.reciprocals
        self.rest_rows = known.rest_rows
        if self._lanes is not None:
            # what native code takes that never changes
            dt = (model.options.time_step,)
            self._shares, self._ways = workspace.shared("corners", dt, found, self._corners)

    def _corners(self) -> tuple[Any, Any]:
        """Shares of the corners in a pair's stiffness, and its direction, by axis."""
        m = self._model
        count = len(m.muscles.pair_tet)
        shares = m.zeros(CORNER_PAIRS * count, m.types.scalar)
        ways = m.zeros((3, count), m.types.scalar)
        kernel, inputs = self._lanes.share_corners, [self._fibers, m.arrays.step.factors]
        with_kernels(lambda: self._launch(kernel, m.tet_count, inputs, [shares, ways]))
        return shares, ways

    def _launch(self, kernel: Any, count: int, inputs: list[Any], outputs: list[Any]) -> None:
        launch(kernel, count, inputs, outputs, self._model.options.device)

    def work(self, positions: Any, velocities: Any, values: Any) -> list[Work]:
        """The work in order, once ``values`` holds the blocks between nodes of the matrix."""
        a, k, s = self._model.arrays, self._kernels, self._state
        own, edges = a.muscles, a.gather
        again = 1 if self._model.options.newton_iterations > 1 else self._unturned

        def stretch(first: int, last: int) -> None:
            if self._lanes is not None:
                inputs = [first, again, self._fibers, self._ways, positions, velocities]
                self._launch(self._lanes.stretch_fibers, last - first, inputs, [s])
                return
            inputs = [first, self._fibers, positions, velocities]
            self._launch(k.stretch_fibers, last - first, inputs, [s])

        def average(first: int, last: int) -> None:
            inputs = [first, self._fibers, own.segment_start, self._segment_pair]
            inputs += [self._rest_lengths, a.step.factors, self.limits]
            self._launch(k.mean_stretches, last - first, inputs, [s, self.lengths, self.reaches])

        def stiffen(first: int, last: int) -> None:
            kernel, known = k.stiffen_tets, [a.step.factors]
            if self._lanes is not None:
                kernel, known = self._lanes.stiffen_tets, [a.step.factors, self._shares]
            inputs = [first, self._unturned, self._fibers, *known, s]
            self._launch(kernel, last - first, inputs, [self._blocks])

        def add(first: int, last: int) -> None:
            inputs = [first, edges.edge_start, edges.edge_corners, edges.edge_slots]
            self._launch(self._edges.stiffen_edges, last - first, [*inputs, self._blocks], [values])

        m = self._model
        return [
            (m.tet_count, stretch),
            (m.segment_count, average),
            (m.tet_count, stiffen),
            (len(m.topology.edge_slots), add),
        ]

    def launch_tensions(self, limits: Any, tensions: Any) -> None:
        """Launch the tensions (s,) Pa that a step begins with, of rest lengths (s,) m."""
        inputs = [self._rest_lengths, limits, self.lengths, self.reaches, self._state]
        count = self._model.segment_count
        self._launch(self._kernels.first_tensions, count, inputs, [tensions])

    def launch_forces(self, tensions: Any, forces: Any, *, again: bool) -> None:
        """Launch the forces (4 m,) vec3 N, by corner, of tensions (s,), Pa.

        ``again``: for a further Newton iteration, about the velocities last worked with.
        """
        inputs = [self._unturned, self._fibers, self._given_back, int(again), tensions]
        self._launch(
            self._kernels.pull_tets, self._model.tet_count, [*inputs, self._state], [forces]
        )

    def launch_weights(self) -> Any:
        """Launch w / |F d| of the pairs, by tet and by segment, (q,) each."""
        k, count = self._kernels, len(self._weights)
        inputs = [self._model.arrays.muscles.pair_weight, self._state.reciprocals]
        self._launch(k.weigh_pairs, count, inputs, [self._weights])
        self._launch(k.by_segment, count, [self._segment_pair, self._weights], [self._sorted])
        return self._sorted


@dataclass(frozen=True, eq=False)
class _FiberArrays:
    """Constant arrays of fibres in tets that all copies of a body share; q pairs, s segments.

    Attributes:
        volume: (q,) scalar m^3, w V0.
        share: (q,) scalar, its part of the segment's.
        segment_pair: (q,) int32, pairs by segment.
        rest_lengths: (s,) scalar m.
        rest_rows: (m,) mat33, rows V0 g_a of the corners 1 to 3.
    """

    volume: DeviceArray
    share: DeviceArray
    segment_pair: DeviceArray
    rest_lengths: DeviceArray
    rest_rows: DeviceArray

    @staticmethod
    def of(model: Model) -> _FiberArrays:
        """Those of a model with muscles."""
        layout, scalar = model.muscles, model.types.scalar
        volume = layout.pair_weight * model.body.mesh.volumes[layout.pair_tet]
        whole = np.bincount(layout.pair_segment, volume, model.segment_count)
        share = volume / np.where(whole > 0.0, whole, 1.0)[layout.pair_segment]
        by_segment = np.argsort(layout.pair_segment, kind="stable").astype(np.int32)
        kernel = make_implicit_muscles(model.options.precision).rest_rows
        rows = model.zeros(model.tet_count, model.types.mat33)
        mesh = [model.arrays.mesh.rest_inverse, model.arrays.mesh.rest_volume]
        device = model.options.device
        with_kernels(lambda: launch(kernel, model.tet_count, mesh, [rows], device))
        return _FiberArrays(
            volume=model.array(volume, scalar),
            share=model.array(share, scalar),
            segment_pair=model.array(by_segment, wp.int32),
            rest_lengths=model.array(layout.rest_lengths, scalar),
            rest_rows=rows,
        )


def _given_back(model: Model) -> np.ndarray[Any, np.dtype[np.float64]]:
    """(m,) s, by which the rate of S f in a tet is still to be given back; see ``pull_tets``.

    A Newton iteration gives back dt^2 / (dt lambda + dt^2) of what the matrix takes, as for
    elasticity the rest is damping. Muscles have none.
    """
    dt = model.options.time_step
    left = np.zeros(model.tet_count)
    for part in model.materials:
        left[part.tets] = dt * (1.0 - dt * dt / part.stiffness_factor)
    return left
