"""Rows of ``M~ W = J^T`` solved side by side, in blocks of 16, starting from the last W."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np
import numpy.typing as npt
import warp as wp

from warp_softbody.arrays import FloatArray
from warp_softbody.device.array_copies import Copies, copied, write_back
from warp_softbody.device.host_view import HostView, HostViews
from warp_softbody.device.launching import launch
from warp_softbody.device.warp_runtime import captured, prepare_captures
from warp_softbody.engine.muscle_map import MuscleMap
from warp_softbody.engine.stepper import Stepper
from warp_softbody.kernels.linear.block_lanes import lanes_on
from warp_softbody.kernels.linear.block_pcg import make_block_gradients
from warp_softbody.kernels.linear.codes import BlockCounter, VelocityConstraint
from warp_softbody.kernels.precision import BLOCK
from warp_softbody.linear.block_ldlt import Freedom
from warp_softbody.linear.preconditioner import make_preconditioner
from warp_softbody.linear.renewal import Renewal

BLOCK_COST = 3
"""Cost of an iteration of a block in units of one for a single right-hand side."""


@dataclass(frozen=True, eq=False)
class BlockSolution:
    """What is known of r rows of J once they are solved for.

    Attributes:
        responses: (r, 3n), velocities per unit impulse along each row.
        free_velocity: (r,), J v+ without muscle tension and contact.
        muscle_map: (r, segments or 1), change of J v+ per metre of (l_d - l).
    """

    responses: FloatArray
    free_velocity: npt.NDArray[np.floating]
    muscle_map: FloatArray


@dataclass(frozen=True, eq=False, repr=False)
class SavedResponses:
    """Where the next solve of a `BlockSolver` begins.

    Attributes:
        rows: that were last solved for.
        blocks: that there was room for.
        arrays: responses, and what the preconditioner keeps.
        age: of that.
    """

    rows: int
    blocks: int
    arrays: Copies
    age: float


class BlockSolver:
    """Conjugate gradients on blocks of rows with the matrix that a stepper has assembled."""

    def __init__(
        self, stepper: Stepper, row_capacity: int, tolerance: float, most_iterations: int
    ) -> None:
        """Work arrays for a number of rows; they grow when more are asked for."""
        model, types = stepper.model, stepper.model.types
        self._stepper = stepper
        self._most_iterations = most_iterations
        self._kernels = make_block_gradients(model.options.precision)
        options = model.options
        native = lanes_on(options.device, options.precision) if options.native_code else None
        self._products = native or self._kernels
        self._muscle_map = MuscleMap(stepper, native) if model.segment_count else None
        self._counters = model.zeros(len(BlockCounter), wp.int32)
        self._tolerance = model.array([tolerance], types.scalar)
        matrix = (stepper.assembly.values, stepper.assembly.node_rotations)
        self._preconditioner = make_preconditioner(
            model.system, *matrix, stepper.workspace, serves="blocks"
        )
        self._renewal = Renewal(self._preconditioner, model.system)
        # contact is not in this matrix: only fixed nodes are held, nothing slides
        self._unbound = Freedom(
            model.zeros(model.node_count, wp.int32),
            model.zeros(model.node_count, types.vec3),
            model.zeros(model.node_count, types.mat33),
        )
        self._read_held = HostView(model.arrays.masses.fixed).read
        self._write_kinds = HostView(self._unbound.kinds).write
        self._holding = -1
        self._take_held()
        self._allocate(-(-row_capacity // BLOCK))
        prepare_captures(options.device, self._launch)

    def _take_held(self) -> bool:
        """Hold the nodes that the stepper holds; whether these are others than before."""
        if self._holding == self._stepper.holding:
            return False
        held = self._read_held() != 0
        self._write_kinds(np.where(held, VelocityConstraint.FIXED, VelocityConstraint.NONE))
        self._holding = self._stepper.holding
        return True

    def _allocate(self, blocks: int) -> None:
        """Work arrays for a number of blocks of rows, and no graphs yet."""
        model = self._stepper.model
        block = model.types.block
        sizes = dict.fromkeys(("j", "r", "z", "p", "q", "half"), 3 * model.node_count)
        sizes |= dict.fromkeys(("rr", "rz", "pq"), model.system.chunk_count)
        sizes |= {"stretch": 6 * model.tet_count, "maps": max(1, model.segment_count)}
        scalars = ("target", "old product", "product", "curvature", "response")
        work = self._stepper.workspace.part("block solver", model.allocator)
        self._room = {name: work.zeros((blocks, size), block) for name, size in sizes.items()}
        self._room |= {name: work.zeros(blocks, block) for name in scalars}
        # where the next step begins
        self._room["x"] = model.zeros((blocks, 3 * model.node_count), block)
        self._blocks = blocks
        self._work = self._room
        self._views = HostViews()
        self._last_rows = 0
        self._graphs: dict[int, Any] = {}

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

    @property
    def room(self) -> Mapping[str, Any]:
        """All arrays by name, of as many blocks as there is room for; others once there is more.

        ``j`` takes the rows, ``x`` has the responses, ``response`` J v+ and ``maps`` that of
        muscles.
        """
        return self._room

    def reserve(self, count: int) -> None:
        """Make room for a number of rows."""
        if count > self.row_capacity:
            self._allocate(-(-count // BLOCK))

    def save(self) -> SavedResponses:
        """Where the next solve begins."""
        return SavedResponses(
            *(self._last_rows, self._blocks, copied(self._changing), self._preconditioner.age)
        )

    def restore(self, saved: SavedResponses) -> None:
        """Begin the next solve where another one of the same model once did."""
        if saved.blocks != self._blocks:
            self._allocate(saved.blocks)
        self._take_held()
        self._use(saved.rows)
        write_back(self._changing, saved.arrays)
        self._preconditioner.age = saved.age

    @property
    def _changing(self) -> tuple[Any, ...]:
        return (self._room["x"], *self._preconditioner.kept)

    def solve(self, rows: FloatArray) -> tuple[int, BlockSolution]:
        """Run the block iteration on rows of J; its iterations, and what it found."""
        if len(rows) != self._last_rows:
            self._use(len(rows))
        self._views.write(self._work["j"], self._to_blocks(rows))
        iterations = self.iterate(len(rows))
        return iterations, self._solution(len(rows))

    def iterate(self, count: int) -> int:
        """Run the iteration on rows that stand in the blocks; how many it took."""
        if count != self._last_rows:
            self._use(count)
        model = self._stepper.model
        if self._take_held():
            self._preconditioner.age = float("inf")
        self._renewal.choose()
        blocks = len(self._work["j"])
        if blocks not in self._graphs:
            self._graphs[blocks] = captured(model.options.device, self._launch)
        wp.capture_launch(self._graphs[blocks])
        self._renewal.done()
        iterations = int(self._views.read(self._counters)[BlockCounter.ITERATIONS])
        self._preconditioner.used(BLOCK_COST * iterations, fresh=BLOCK_COST)
        return iterations

    def _solution(self, count: int) -> BlockSolution:
        """What the iteration left for a number of rows."""
        return BlockSolution(
            responses=self._from_blocks(self._views.read(self._work["x"]), count),
            free_velocity=self._views.read(self._work["response"]).reshape(-1)[:count],
            muscle_map=self._from_blocks(self._views.read(self._work["maps"]), count),
        )

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

    def _launch(self) -> None:
        model, a, k = self._stepper.model, self._stepper.model.arrays, self._kernels
        w, blocks = self._work, len(self._work["j"])
        self._renewal.launch(self._unbound)
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
