"""One step's linear maps by native code, from rows of J to what a plan needs of them.

What `ReducedDynamics.solve` does in NumPy around the solve is done here by two launches, which
take rows as they are mostly made: weights of nodes along an axis. NumPy is the reference.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

from warp_softbody.arrays import FloatArray
from warp_softbody.device.host_program import HostProgram
from warp_softbody.engine.block_solver import BlockSolver
from warp_softbody.engine.model import Model
from warp_softbody.engine.stepper import Stepper
from warp_softbody.inputs.records import Value, unchecked
from warp_softbody.kernels.control.reduced_maps import COUNTS, NUMBERS, MapSizes, make_reduced_maps
from warp_softbody.kernels.linear.block_lanes import lanes_on

MOST_SIZES = 8
"""Numbers of rows and patches whose arrays are kept."""


@dataclass(frozen=True, kw_only=True, eq=False, repr=False)
class StepMaps(Value):
    """What `ControlProblem` holds but for the rows and their responses.

    Attributes:
        compliance: J M~^-1 J^T, (r, r), symmetric.
        free_velocity: J v+ without muscle tension and contact, (r,).
        muscle_map: change of J v+ per metre of (l_d - l), (r, s).
        lengths: l, (s,) m, as in `ControlProblem`.
        reaches: the most that l_d may be, (s,) m.
        rest_lengths: l_0, (s,) m.
        iterations: of the block solve.
        converged: whether every row reached the tolerance.
    """

    compliance: FloatArray
    free_velocity: FloatArray
    muscle_map: FloatArray
    lengths: FloatArray
    reaches: FloatArray
    rest_lengths: FloatArray
    iterations: int
    converged: bool


def native_maps_on(model: Model) -> bool:
    """Whether the native code serves a model: one with muscles, on the processor."""
    options = model.options
    there = options.native_code and lanes_on(options.device, options.precision) is not None
    return there and model.segment_count > 0


class NativeMaps:
    """Makes the maps of one step after another, at the state last assembled by a stepper."""

    def __init__(self, stepper: Stepper, blocks: BlockSolver, most_iterations: int) -> None:
        """Solve by ``blocks``, which has not converged after ``most_iterations``."""
        self._stepper = stepper
        self._blocks = blocks
        self._most_iterations = most_iterations
        self._rooms: dict[tuple[int, int], _Room] = {}
        self._known: Any = None

    def solve(
        self,
        rows: Sequence[FloatArray],
        weights: Sequence[FloatArray],
        frames: Sequence[FloatArray],
    ) -> StepMaps | None:
        """The maps of the arguments of `ReducedDynamics.fast_maps`; None where these are none."""
        room = self._room(sum(map(len, rows)), len(weights))
        count = room.gather(rows, weights, frames)
        if count is None:
            return None
        iterations = self._blocks.iterate(count)
        return room.conclude(iterations, converged=iterations < self._most_iterations)

    def _room(self, rows: int, patches: int) -> _Room:
        """Arrays for so many rows and patches, on the block solver's present ones."""
        self._blocks.reserve(rows + 3 * patches)
        if self._known is not self._blocks.room or len(self._rooms) >= MOST_SIZES:
            self._rooms.clear()
            self._known = self._blocks.room
        room = self._rooms.get((rows, patches))
        if room is None:
            room = self._rooms[rows, patches] = _Room(self._stepper, self._blocks, rows, patches)
        return room


class _Room:
    """The arrays of one number of rows and patches."""

    def __init__(self, stepper: Stepper, blocks: BlockSolver, rows: int, patches: int) -> None:
        model, room = stepper.model, blocks.room
        self._rest_lengths = model.muscles.rest_lengths
        sizes = MapSizes(
            *(rows, patches, model.node_count, model.segment_count),
            *(len(room["j"]), int(model.fixed.any())),
        )
        numbers = {name: shape(sizes) for name, shape in NUMBERS.items()}
        counts = {name: shape(sizes) for name, shape in COUNTS.items()}
        program = stepper.workspace.shared(
            "maps", tuple(sizes), (), lambda: HostProgram(numbers, counts)
        )
        self._numbers, self._counts = program.numbers, program.counts
        self._counts["settings"][...] = sizes
        self._masses = model.masses
        damping = model.scene.character.material.mass_damping
        free = 1.0 / (1.0 + model.options.time_step * damping)
        self._scalars = (float(model.masses.sum()), free)
        kernels = make_reduced_maps(model.options.precision)
        found = [room["x"], room["response"], room["maps"], stepper.assembly.momentum]
        found += [stepper.lengths, stepper.reaches]
        self._gather = program.running(kernels.gather, reads=[], writes=[room["j"]])
        self._conclude = program.running(kernels.conclude, reads=found, writes=[])

    def gather(
        self,
        rows: Sequence[FloatArray],
        weights: Sequence[FloatArray],
        frames: Sequence[FloatArray],
    ) -> int | None:
        """Take rows apart; how many are to be solved for, None where they are not finite."""
        # other models may have used the arrays since
        self._numbers["masses"][...] = self._masses
        self._numbers["scalars"][...] = self._scalars
        whole, begin = self._numbers["rows"], 0
        for part in rows:
            whole[begin : begin + len(part)] = part
            begin += len(part)
        for own, given in ((self._numbers["weights"], weights), (self._numbers["frames"], frames)):
            for place, value in zip(own, given, strict=True):
                place[...] = value
        self._gather()
        count, finite = self._counts["solved"].tolist()
        return count if finite else None

    def conclude(self, iterations: int, *, converged: bool) -> StepMaps | None:
        """The maps, once the rows are solved for; None where they are not finite."""
        self._conclude()
        numbers = self._numbers
        if not self._counts["solved"][1]:
            return None
        return unchecked(
            StepMaps,
            compliance=numbers["compliance"].copy(),
            free_velocity=numbers["free_velocity"].copy(),
            muscle_map=numbers["muscle_map"].copy(),
            lengths=numbers["lengths"].copy(),
            reaches=numbers["reaches"].copy(),
            rest_lengths=self._rest_lengths,
            iterations=iterations,
            converged=converged,
        )
