"""From engine to controllers: one step's linear maps in NumPy.

A controller wants some linear functions ``y = J v+`` of the next velocities. With ``M~ W = J^T``
solved once, they are ``y = W^T b + (W^T dt A)(l_d - l) + (J W) f`` with b the known right-hand side
and f impulses along rows of J: small and dense, whatever the size of the mesh (paper eq. 9 and 11,
eliminated).
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
import numpy.typing as npt
import warp as wp

from warp_softbody.arrays import FloatArray
from warp_softbody.device.host_view import HostViews
from warp_softbody.device.launching import launch
from warp_softbody.device.turns import shares_warp
from warp_softbody.device.warp_runtime import captured
from warp_softbody.engine.free_turn import FreeTurn
from warp_softbody.engine.muscle_map import MuscleMap
from warp_softbody.engine.stepper import Stepper
from warp_softbody.errors import InputError
from warp_softbody.inputs import array_checks, checks
from warp_softbody.inputs.records import Value
from warp_softbody.kernels.linear.block_lanes import lanes_on
from warp_softbody.kernels.linear.block_pcg import make_block_gradients
from warp_softbody.kernels.linear.codes import BlockCounter, VelocityConstraint
from warp_softbody.kernels.precision import BLOCK
from warp_softbody.linear.block_ldlt import Freedom
from warp_softbody.linear.preconditioner import make_preconditioner

BLOCK_COST = 3
"""Cost of an iteration of a block in units of one for a single right-hand side."""


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
        lengths: l, (s,) m, at the start of the step.
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
    rest_lengths: FloatArray
    iterations: int
    converged: bool


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
    ) -> None:
        """Work arrays for up to ``row_capacity`` rows of J; they grow when more are asked for.

        Args:
            stepper: whose assembled matrix is solved with.
            row_capacity: rows of J.
            tolerance: relative residual of each row at which its solve stops.
            max_iterations: of one block solve; one that needs more is not converged.
        """
        checks.instance("stepper of a ReducedDynamics", stepper, Stepper)
        row_capacity = checks.whole(
            "row_capacity of a ReducedDynamics", row_capacity, low=1, high=2**16
        )
        tolerance = checks.number("tolerance of a ReducedDynamics", tolerance, above=0.0, below=1.0)
        self._most_iterations = checks.whole(
            "max_iterations of a ReducedDynamics", max_iterations, low=1
        )
        model = stepper.model
        types = model.types
        self._stepper = stepper
        self._kernels = make_block_gradients(model.options.precision)
        options = model.options
        native = lanes_on(options.device, options.precision) if options.native_code else None
        self._products = native or self._kernels
        self._muscle_map = MuscleMap(stepper, native) if model.segment_count else None
        self._counters = model.zeros(len(BlockCounter), wp.int32)
        self._tolerance = model.array([tolerance], types.scalar)
        matrix = (stepper.assembly.values, stepper.assembly.node_rotations)
        self._preconditioner = make_preconditioner(model.system, *matrix)
        # contact is not in this matrix: only fixed nodes are held, nothing slides
        self._unbound = Freedom(
            model.array(
                np.where(model.fixed, VelocityConstraint.FIXED, VelocityConstraint.NONE), wp.int32
            ),
            model.zeros(model.node_count, types.vec3),
            model.zeros(model.node_count, types.mat33),
        )
        self._allocate(-(-row_capacity // BLOCK))

    def _allocate(self, blocks: int) -> None:
        """Work arrays for a number of blocks of rows, and no graphs yet."""
        model = self._stepper.model
        block = model.types.block
        sizes = dict.fromkeys(("j", "x", "r", "z", "p", "q", "half"), 3 * model.node_count)
        sizes |= dict.fromkeys(("rr", "rz", "pq"), model.system.chunk_count)
        sizes |= {"stretch": 6 * model.tet_count, "maps": max(1, model.segment_count)}
        scalars = ("target", "old product", "product", "curvature", "response")
        self._room = {name: model.zeros((blocks, size), block) for name, size in sizes.items()}
        self._room |= {name: model.zeros(blocks, block) for name in scalars}
        self._blocks = blocks
        self._work = self._room
        self._views = HostViews()
        self._last_rows = 0
        self._graphs: dict[tuple[bool, int], Any] = {}

    def _use(self, count: int) -> None:
        """Begin anew with as many of the blocks as hold a number of rows."""
        blocks = max(1, -(-count // BLOCK))
        if blocks > self._blocks:
            self._allocate(blocks)
        self._work = {name: array[:blocks] for name, array in self._room.items()}
        self._views = HostViews()
        self._work["x"].zero_()
        self._last_rows = count

    @property
    def row_capacity(self) -> int:
        """Rows of J that there is room for."""
        return self._blocks * BLOCK

    @shares_warp
    def solve(self, rows: FloatArray, *, free: bool = False) -> ControlProblem:
        """The maps of rows J (r, 3n) at the state last assembled by the stepper.

        ``free`` says that nothing touches the body, so that the step keeps its angular momentum.
        """
        model = self._stepper.model
        rows = array_checks.array("rows of a ReducedDynamics", rows, (None, None))
        if rows.ndim != 2 or rows.shape[1] != 3 * model.node_count:
            raise InputError(
                f"reduced dynamics take rows of {3 * model.node_count} numbers, "
                f"got shape {rows.shape}"
            )
        self._stepper.follow_plan()
        turn = self._free_turn(rows) if free else None
        left = rows if turn is None else turn.rows
        moved, shifts = self._translations(left)
        others = np.flatnonzero(~moved)
        iterations = self._solve_blocks(left[others])
        count, segments = len(rows), model.segment_count
        responses = np.empty((count, rows.shape[1]))
        responses[others] = self._from_blocks(self._views.read(self._work["x"]), len(others))
        responses[moved] = np.tile(shifts, model.node_count)
        free_velocity = np.empty(count)
        free_velocity[others] = self._views.read(self._work["response"]).reshape(-1)[: len(others)]
        known = self._views.read(self._stepper.assembly.momentum)
        momenta = known.sum(axis=0, dtype=np.float64)
        free_velocity[moved] = shifts @ momenta
        maps = np.zeros((count, segments))
        by_segment = self._views.read(self._work["maps"])
        maps[others] = self._from_blocks(by_segment, len(others))[:, :segments]
        if turn is not None:
            # muscles have no torque, so that their maps stay
            responses += turn.responses
            free_velocity += turn.responses @ known.astype(np.float64).ravel()
        compliance = rows @ responses.T
        return ControlProblem(
            rows=rows,
            responses=responses,
            compliance=0.5 * (compliance + compliance.T),
            free_velocity=free_velocity,
            muscle_map=maps,
            lengths=self._views.read(self._stepper.lengths).astype(np.float64),
            rest_lengths=model.muscles.rest_lengths,
            iterations=iterations,
            converged=iterations < self._most_iterations,
        )

    def _free_turn(self, rows: FloatArray) -> FreeTurn | None:
        """What the step's balance of spin does to rows; None where it does nothing."""
        model, state = self._stepper.model, self._stepper.assembled
        one = len(model.scene.parts) == 1 and not len(model.body.fixed)
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
        if len(model.body.fixed):
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

    def _solve_blocks(self, rows: FloatArray) -> int:
        """Run the block iteration on rows; its iterations."""
        model = self._stepper.model
        if len(rows) != self._last_rows:
            self._use(len(rows))
        self._views.write(self._work["j"], self._to_blocks(rows))
        renew = self._preconditioner.stale
        key = (renew, len(self._work["j"]))
        if key not in self._graphs:
            self._graphs[key] = captured(model.options.device, lambda: self._launch(renew))
        wp.capture_launch(self._graphs[key])
        if renew:
            self._preconditioner.renewed()
        iterations = int(self._views.read(self._counters)[BlockCounter.ITERATIONS])
        self._preconditioner.used(BLOCK_COST * iterations, fresh=BLOCK_COST)
        return iterations

    def _to_blocks(self, rows: FloatArray) -> npt.NDArray[np.floating]:
        dtype = np.dtype(self._stepper.model.options.precision)
        blocks = np.zeros((len(self._work["j"]), rows.shape[1], BLOCK), dtype=dtype)
        for begin, block in zip(range(0, len(rows), BLOCK), blocks, strict=False):
            part = rows[begin : begin + BLOCK]
            block[:, : len(part)] = part.T
        return blocks

    @staticmethod
    def _from_blocks(blocks: npt.NDArray[np.floating], count: int) -> FloatArray:
        """(blocks, k, 16) to (count, k)."""
        flat = blocks.transpose(0, 2, 1).reshape(-1, blocks.shape[1])
        return np.asarray(flat[:count], dtype=np.float64)

    def _run(self, kernel: Any, dim: Any, inputs: list[Any], outputs: list[Any]) -> None:
        device = self._stepper.model.options.device
        launch(kernel, dim, inputs, outputs, device)

    def _launch(self, renew: bool) -> None:
        model, a, k = self._stepper.model, self._stepper.model.arrays, self._kernels
        w, blocks = self._work, len(self._work["j"])
        if renew:
            self._preconditioner.renew(self._unbound)
        self._preconditioner.prepare(self._unbound)
        size = [model.system.chunk, model.node_count]
        rows = [a.masses.fixed, a.pattern.row_start, a.pattern.column, a.masses.damped_mass]
        matrix = self._stepper.assembly.values
        chunks = (blocks, model.system.chunk_count)
        residual = [w["j"], w["x"]]
        products = self._products
        self._run(k.squares, chunks, [*size, w["j"]], [w["rr"]])
        self._run(k.set_targets, blocks, [self._tolerance, w["rr"]], [w["target"]])
        self._run(products.residual, chunks, [*size, *rows, matrix, *residual], [w["r"], w["rr"]])
        ends = [w["old product"], self._counters]
        self._run(k.begin, 1, [w["rr"], w["target"]], ends)

        def iterate() -> None:
            self._preconditioner.apply_block(w["r"], w["half"], w["z"])
            self._run(k.products, chunks, [*size, a.masses.fixed, w["r"]], [w["z"], w["rz"]])
            self._run(k.add_up, blocks, [w["rz"]], [w["product"]])
            inputs = [*size, w["product"], w["old product"], w["z"]]
            self._run(k.direction, chunks, inputs, [w["p"]])
            inputs = [*size, *rows, matrix, w["p"]]
            self._run(products.curvature, chunks, inputs, [w["q"], w["pq"]])
            self._run(k.add_up, blocks, [w["pq"]], [w["curvature"]])
            inputs = [*size, w["product"], w["curvature"], w["p"], w["q"]]
            self._run(k.advance, chunks, inputs, [w["x"], w["r"], w["rr"]])
            inputs = [self._most_iterations, w["product"], w["rr"], w["target"]]
            self._run(k.conclude, 1, inputs, ends)

        wp.capture_while(
            self._counters[BlockCounter.CONDITION : BlockCounter.CONDITION + 1], iterate
        )
        inputs = [model.node_count, w["x"], self._stepper.assembly.momentum]
        self._run(k.free_response, blocks, inputs, [w["response"]])
        if self._muscle_map is not None:
            self._muscle_map.launch(w["x"], w["stretch"], w["maps"])


Bridge = ReducedDynamics
"""The name that this class had."""
