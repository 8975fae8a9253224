"""The linear system of a falling beam's step, and conjugate gradients to solve it, in NumPy."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np
import numpy.typing as npt
import scipy.sparse as sp

from benchmarks.beam.cantilever import TIME_STEP
from benchmarks.beam.ours import OurBeam
from warp_softbody.accuracy.runs.peers.beam import Cantilever
from warp_softbody.accuracy.runs.peers.corotation import CorotationalSystem
from warp_softbody.arrays import FloatArray

Apply = Callable[[FloatArray], FloatArray]

SWING_STEPS = 25
"""Steps to mid swing: a quarter of the slowest swing's period, which is about a second."""

TOLERANCE = 1e-5
MOST_ITERATIONS = 10_000


@dataclass(frozen=True, kw_only=True)
class StepSystem:
    """``A v+ = b`` over the free nodes, whose numbers are dense and in the mesh's order.

    Attributes:
        beam: the body at rest.
        free: (n,) numbers in the mesh of the free nodes.
        matrix: A, CSR.
        right: b.
        start: v, where the iteration begins.
        rest: A of the rest shape, CSR.
        rotations: (n, 3, 3) of the nodes since rest, means over the tets around them.
    """

    beam: Cantilever
    free: npt.NDArray[np.int64]
    matrix: Any
    right: FloatArray
    start: FloatArray
    rest: Any
    rotations: FloatArray

    @property
    def nodes(self) -> int:
        """Number of free nodes."""
        return len(self.free)

    @cached_property
    def blocks(self) -> int:
        """Number of 3 x 3 blocks of the matrix: one product with it touches each once."""
        return len(blocks_of(self.matrix).indices)


def mid_swing(beam: Cantilever) -> tuple[FloatArray, FloatArray]:
    """Positions, m, and velocities, m/s, that the engine brings the straight beam to."""
    solver = OurBeam(beam, TIME_STEP, "float64")
    for _ in range(SWING_STEPS):
        solver.step()
    state = solver.state()
    assert state is not None
    return state


def step_system(beam: Cantilever, positions: FloatArray, velocities: FloatArray) -> StepSystem:
    """The system of the step from a state."""
    system = CorotationalSystem(beam, TIME_STEP)
    matrix, right = system.assemble(positions, velocities)
    rest, _ = system.assemble(beam.mesh.points, np.zeros_like(velocities))
    free = np.flatnonzero(~beam.fixed)
    return StepSystem(
        beam=beam,
        free=free,
        matrix=matrix,
        right=right[free].ravel(),
        start=velocities[free].ravel(),
        rest=rest,
        rotations=_node_rotations(beam, system.gradients, positions)[free],
    )


def conjugate_gradients(
    system: StepSystem, precondition: Apply, tolerance: float = TOLERANCE
) -> tuple[FloatArray, int]:
    """v+ with ``|b - A v+| <= tolerance |b|``, and the iterations from v that it takes.

    Raises:
        ArithmeticError: it takes more than ``MOST_ITERATIONS``.
    """
    x = system.start.copy()
    r = system.right - system.matrix @ x
    p = np.zeros_like(x)
    stop = tolerance * np.linalg.norm(system.right)
    product = np.inf
    for iteration in range(MOST_ITERATIONS + 1):
        if np.linalg.norm(r) <= stop:
            return x, iteration
        z = precondition(r)
        last, product = product, float(r @ z)
        p = z + product / last * p
        q = system.matrix @ p
        step = product / float(p @ q)
        x += step * p
        r -= step * q
    raise ArithmeticError(f"no convergence in {MOST_ITERATIONS} iterations")


def blocks_of(matrix: Any) -> Any:
    """A matrix as 3 x 3 blocks (BSR), columns in rising order."""
    blocks = matrix.tobsr((3, 3))
    blocks.sort_indices()
    return blocks


def block_diagonal(blocks: npt.NDArray[np.floating[Any]]) -> Any:
    """The CSR matrix with blocks (n, 3, 3) on its diagonal."""
    count = len(blocks)
    entries = (blocks, np.arange(count), np.arange(count + 1))
    return sp.bsr_matrix(entries, shape=(3 * count, 3 * count)).tocsr()


def diagonal_blocks(matrix: Any) -> FloatArray:
    """The diagonal's 3 x 3 blocks, (n, 3, 3)."""
    blocks = blocks_of(matrix)
    row = np.repeat(np.arange(len(blocks.indptr) - 1), np.diff(blocks.indptr))
    return np.asarray(blocks.data[row == blocks.indices])


def _node_rotations(beam: Cantilever, gradients: FloatArray, positions: FloatArray) -> FloatArray:
    """Rotations (n, 3, 3) closest to the volume-weighted sums of those of the tets around."""
    mesh = beam.mesh
    turns = _closest_rotations(np.einsum("mai,maj->mij", positions[mesh.tets], gradients))
    sums = np.zeros((len(mesh.points), 3, 3))
    np.add.at(sums, mesh.tets, (mesh.volumes[:, None, None] * turns)[:, None])
    return _closest_rotations(sums)


def _closest_rotations(matrices: FloatArray) -> FloatArray:
    U, _, Vt = np.linalg.svd(matrices)
    U[:, :, 2] *= np.linalg.det(U @ Vt)[:, None]
    return np.asarray(U @ Vt)
