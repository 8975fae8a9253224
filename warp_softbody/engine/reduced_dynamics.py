"""From engine to controllers: one step's linear maps in NumPy.

A controller wants some linear functions ``y = J v+`` of the next velocities. With ``M~ W = J^T``
solved once, they are ``y = W^T b + (W^T dt A)(l_d - l) + (J W) f`` with b the known right-hand side
and f impulses along rows of J: small and dense, whatever the size of the mesh (paper eq. 9 and 11,
eliminated).
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt
from scipy.sparse import bsr_array

from warp_softbody.arrays import FloatArray
from warp_softbody.device.host_view import HostViews
from warp_softbody.device.turns import shares_warp
from warp_softbody.device.workspace import Workspace
from warp_softbody.engine.block_solver import BlockSolver, SavedResponses
from warp_softbody.engine.free_turn import FreeTurn
from warp_softbody.engine.native_maps import NativeMaps, StepMaps, native_maps_on
from warp_softbody.engine.part_rows import (
    of_own_segments,
    part_named,
    rows_of_whole,
    weights_of_whole,
)
from warp_softbody.engine.stepper import Stepper
from warp_softbody.errors import InputError
from warp_softbody.inputs import array_checks, checks
from warp_softbody.inputs.records import Value, unchecked_copy
from warp_softbody.kernels.precision import BLOCK
from warp_softbody.world.joined_bodies import Part


@dataclass(frozen=True, kw_only=True, eq=False, repr=False)
class ControlProblem(Value):
    """Linear maps of one step for r rows of J and s muscle segments.

    Attributes:
        rows: J, (r, 3n).
        responses: W^T, (r, 3n): velocities per unit impulse along each row; of a body that is free,
            with the turn that a step gives back to its spin (`free_turn`).
        compliance: W^T J^T, (r, r), symmetric.
        free_velocity: J v+ without muscle tension and contact, (r,).
        muscle_map: change of J v+ per metre of (l_d - l), (r, s).
        lengths: l, (s,) m, at the start of the step; of implicit muscles l_0 times their stretch.
        reaches: the most that l_d may be, (s,) m: l, or where implicit muscles lengthen, what they
            reach by the end of the step at their present rates.
        rest_lengths: l_0, (s,) m.
        iterations: of the block solve.
        converged: whether every row reached the tolerance.
    """

    rows: FloatArray
    responses: FloatArray
    compliance: FloatArray
    free_velocity: FloatArray
    muscle_map: FloatArray
    lengths: FloatArray
    reaches: FloatArray
    rest_lengths: FloatArray
    iterations: int
    converged: bool


Maps = ControlProblem | StepMaps
"""One step's linear maps, with or without the rows that they belong to."""


def of_own_body(problem: ControlProblem, rows: FloatArray, part: Part) -> ControlProblem:
    """A problem whose rows (r, 3 own) and segments are those of one body."""
    own = slice(3 * part.nodes.start, 3 * part.nodes.stop)
    responses = problem.responses[:, own]
    return of_own_segments(unchecked_copy(problem, rows=rows, responses=responses), part)


class ReducedDynamics:
    """Solves M~ W = J^T for the controller, in blocks of 16 rows, starting from the last W."""

    @shares_warp
    def __init__(
        self,
        stepper: Stepper,
        row_capacity: int = BLOCK,
        *,
        tolerance: float = 1e-3,
        max_iterations: int = 400,
        body: str | None = None,
    ) -> None:
        """Work arrays for up to ``row_capacity`` rows of J; they grow when more are asked for.

        Args:
            stepper: whose assembled matrix is solved with.
            row_capacity: rows of J.
            tolerance: relative residual of each row at which its solve stops.
            max_iterations: of one block solve; one that needs more is not converged.
            body: name of a body whose nodes rows are of, and whose segments maps are of, as if it
                were alone; None for all bodies.
        """
        checks.instance("stepper of a ReducedDynamics", stepper, Stepper)
        row_capacity = checks.whole(
            "row_capacity of a ReducedDynamics", row_capacity, low=1, high=2**16
        )
        tolerance = checks.number("tolerance of a ReducedDynamics", tolerance, above=0.0, below=1.0)
        self._most_iterations = checks.whole(
            "max_iterations of a ReducedDynamics", max_iterations, low=1
        )
        self._stepper = stepper
        self._part = None if body is None else part_named(stepper.model.scene, body)
        self._views = HostViews()
        self._blocks = BlockSolver(stepper, row_capacity, tolerance, self._most_iterations)
        on = native_maps_on(stepper.model)
        self._native = NativeMaps(stepper, self._blocks, self._most_iterations) if on else None

    @property
    def native_code(self) -> bool:
        """Whether kernels use native code for processors (`SimulationOptions.native_code`)."""
        return self._stepper.model.options.native_code

    @property
    def row_capacity(self) -> int:
        """Rows of J that there is room for."""
        return self._blocks.row_capacity

    @property
    def workspace(self) -> Workspace:
        """Of arrays that hold nothing between steps, that of the stepper."""
        return self._stepper.workspace

    @shares_warp
    def save(self) -> SavedResponses:
        """Where the next solve begins, for `restore`."""
        return self._blocks.save()

    @shares_warp
    def restore(self, saved: SavedResponses) -> None:
        """Begin the next solve where reduced dynamics of the same model once did."""
        self._blocks.restore(saved)

    @shares_warp
    def solve(self, rows: FloatArray, *, free: bool = False) -> ControlProblem:
        """The maps of rows J (r, 3n) at the state last assembled by the stepper.

        ``free`` says that nothing touches the body, so that the step keeps its angular momentum.
        """
        model = self._stepper.model
        part, count = self._part, model.node_count
        own = count if part is None else part.nodes.stop - part.nodes.start
        rows = array_checks.array("rows of a ReducedDynamics", rows, (None, None))
        if rows.ndim != 2 or rows.shape[1] != 3 * own:
            raise InputError(
                f"reduced dynamics take rows of {3 * own} numbers, got shape {rows.shape}"
            )
        if part is None:
            return self._solve(rows, free=free)
        return of_own_body(self._solve(rows_of_whole(rows, part, count), free=free), rows, part)

    def _solve(self, rows: FloatArray, *, free: bool) -> ControlProblem:
        """The maps of rows of all nodes."""
        model = self._stepper.model
        self._stepper.follow_plan()
        turn = self._free_turn(rows) if free else None
        left = rows if turn is None else turn.rows
        moved, shifts = self._translations(left)
        others = np.flatnonzero(~moved)
        iterations, found = self._blocks.solve(left[others])
        count, segments = len(rows), model.segment_count
        responses = np.empty((count, rows.shape[1]))
        responses[others] = found.responses
        responses[moved] = np.tile(shifts, model.node_count)
        free_velocity = np.empty(count)
        free_velocity[others] = found.free_velocity
        known = self._views.read(self._stepper.assembly.momentum)
        momenta = known.sum(axis=0, dtype=np.float64)
        free_velocity[moved] = shifts @ momenta
        maps = np.zeros((count, segments))
        maps[others] = found.muscle_map[:, :segments]
        if turn is not None:
            # muscles have no torque, so that their maps stay
            responses += turn.responses
            free_velocity += turn.responses @ known.astype(np.float64).ravel()
        free_velocity += self._handled_part(rows, responses)
        compliance = rows @ responses.T
        return ControlProblem(
            rows=rows,
            responses=responses,
            compliance=0.5 * (compliance + compliance.T),
            free_velocity=free_velocity,
            muscle_map=maps,
            lengths=self._views.read(self._stepper.lengths).astype(np.float64),
            reaches=self._views.read(self._stepper.reaches).astype(np.float64),
            rest_lengths=model.muscles.rest_lengths,
            iterations=iterations,
            converged=iterations < self._most_iterations,
        )

    def _handled_part(self, rows: FloatArray, responses: FloatArray) -> FloatArray:
        """What rows see of the nodes that handles move: their velocities, and what they pull."""
        handled = self._stepper.handled
        if handled is None:
            return np.zeros(len(rows))
        model, read = self._stepper.model, self._views.read
        given = read(handled).astype(np.float64).ravel()
        topology, values = model.topology, read(self._stepper.assembly.values).astype(np.float64)
        matrix = bsr_array((values, topology.column, topology.row_start), blocksize=(3, 3))
        # held nodes do not respond, so that what pulls at them does not count
        return np.asarray(rows @ given - responses @ (matrix @ given))

    @shares_warp
    def fast_maps(
        self,
        rows: Sequence[FloatArray],
        weights: Sequence[FloatArray],
        frames: Sequence[FloatArray],
    ) -> StepMaps | None:
        """The maps of `solve` to rounding, by native code; None where `solve` has to be asked.

        That is on other devices than the processor, with handles, and where rows are not finite.

        Args:
            rows: matrices (k, 3n), the first rows of J.
            weights: of the nodes (n,) of each patch, whose velocity is three more rows.
            frames: (3, 3), of each patch, the axes of these rows.
        """
        if self._native is None or self._stepper.handled is not None:
            return None
        self._stepper.follow_plan()
        part, count = self._part, self._stepper.model.node_count
        if part is None:
            return self._native.solve(rows, weights, frames)
        found = self._native.solve(
            [rows_of_whole(each, part, count) for each in rows],
            [weights_of_whole(each, part, count) for each in weights],
            frames,
        )
        return None if found is None else of_own_segments(found, part)

    @property
    def _holds(self) -> bool:
        """Whether any node is held in the step."""
        model = self._stepper.model
        if not model.held_count:
            return bool(model.fixed.any())
        return bool(self._views.read(model.arrays.masses.fixed).any())

    def _free_turn(self, rows: FloatArray) -> FreeTurn | None:
        """What the step's balance of spin does to rows; None where it does nothing."""
        model, state = self._stepper.model, self._stepper.assembled
        one = len(model.scene.parts) == 1 and not self._holds
        if not one or state is None or model.options.newton_iterations > 1:
            return None
        positions = self._views.read(state.positions).astype(np.float64)
        masses = model.masses * model.materials[0].mass_factor
        return FreeTurn.of(rows, positions, masses)

    def _translations(self, rows: FloatArray) -> tuple[npt.NDArray[np.bool_], FloatArray]:
        """Rows that are momenta, m d at every node, and their responses d / (1 + dt mu).

        A rigid translation is in the null space of K, so M~ d = (1 + dt mu) M d where no node is
        fixed.
        """
        model = self._stepper.model
        if self._holds:
            return np.zeros(len(rows), dtype=bool), np.zeros((0, 3))
        by_node = rows.reshape(len(rows), model.node_count, 3)
        first, last = by_node[:, 0] / model.masses[0], by_node[:, -1] / model.masses[-1]
        # most rows are told apart by two nodes
        size = np.maximum.reduce(np.abs(first), axis=1)
        apart = np.maximum.reduce(np.abs(last - first), axis=1)
        likely = np.flatnonzero((apart <= 1e-9 * size) & (size > 0.0))
        taken = by_node[likely]
        direction = taken.sum(axis=1) / model.masses.sum()
        miss = np.abs(taken / model.masses[:, None] - direction[:, None])
        most = np.maximum.reduce(miss.reshape(len(likely), rows.shape[1]), axis=1)
        sure = most <= 1e-9 * np.maximum.reduce(np.abs(direction), axis=1)
        moved = np.zeros(len(rows), dtype=bool)
        moved[likely[sure]] = True
        damping = model.scene.character.material.mass_damping
        return moved, direction[sure] / (1.0 + model.options.time_step * damping)


Bridge = ReducedDynamics
"""The name that this class had."""
