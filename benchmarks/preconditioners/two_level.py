"""Preconditioners with a coarse space of the rigid motions of aggregates of nodes."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
import scipy.sparse as sp
from scipy.sparse.linalg import eigsh

from benchmarks.preconditioners.factors import BLOCK_PRODUCT, Factor, factorise, sweeps
from benchmarks.preconditioners.one_level import CandidatePreconditioner, inverse_diagonal
from benchmarks.preconditioners.system import (
    StepSystem,
    block_diagonal,
    blocks_of,
    diagonal_blocks,
)
from warp_softbody.arrays import FloatArray
from warp_softbody.linear.aggregation import REGULARISATION, build_aggregation
from warp_softbody.linear.block_sparsity import build_topology

GALERKIN_PRODUCTS = 5
"""Products of two blocks that a block of A takes on its way into the coarse matrix: a rotation on
either side, and an offset on the right, the left and both."""


@dataclass(frozen=True)
class CoarseSpace:
    """A correction ``P (P^T A P)^-1 P^T`` and its price in 3 x 3 blocks.

    Attributes:
        motions: P, CSR, of the present pose.
        back: its transpose, CSR.
        factor: of the coarse matrix.
        touched: blocks multiplied by a vector in one correction.
        stored: blocks kept.
    """

    motions: Any
    back: Any
    factor: Factor
    touched: float
    stored: float

    def correct(self, residual: FloatArray) -> FloatArray:
        """The coarse correction of a residual."""
        correction: FloatArray = self.motions @ self.factor.solve(self.back @ residual)
        return correction


def rigid_motions(system: StepSystem) -> Any:
    """P at rest, BSR: a translation and a turn of each of the engine's aggregates."""
    mesh = system.beam.mesh
    topology = build_topology(mesh.tets, len(mesh.points))
    aggregation = build_aggregation(topology, system.beam.fixed, mesh.points)
    owner, offset = aggregation.aggregate_of[system.free], aggregation.offsets[system.free]
    n = system.nodes
    # row c of the second block takes the turn w to component c of w x offset
    parts = np.stack([np.tile(np.eye(3), (n, 1, 1)), np.cross(offset[:, None], np.eye(3))], axis=1)
    columns = (2 * owner[:, None] + np.arange(2)).ravel()
    entries = (parts.reshape(-1, 3, 3), columns, 2 * np.arange(n + 1))
    return sp.bsr_matrix(entries, shape=(3 * n, 6 * aggregation.count))


def coarse_space(
    system: StepSystem, *, smoothed: bool = False, present: bool = False
) -> CoarseSpace:
    """Rigid motions, of the rest shape's matrix unless ``present``."""
    at_rest = rigid_motions(system).tocsr()
    # the engine keeps an offset a node, a third of a block; other motions are kept as blocks
    kept = system.nodes / 3.0
    if smoothed:
        at_rest = _smooth(system, at_rest)
        kept = float(len(blocks_of(at_rest).indices))
    motions = block_diagonal(system.rotations) @ at_rest
    coarse = motions.T @ system.matrix @ motions if present else at_rest.T @ system.rest @ at_rest
    factor = factorise(regularised(coarse))
    moved = kept + system.nodes
    return CoarseSpace(
        motions, motions.T.tocsr(), factor, 2.0 * moved + factor.touched, moved + factor.stored
    )


def regularised(coarse: Any) -> Any:
    """A coarse matrix that is invertible, as the engine makes it so."""
    size = np.trace(diagonal_blocks(coarse), axis1=1, axis2=2) / 3.0
    size = np.maximum(size, 1e-3 * size.max())
    return (coarse + sp.diags(np.repeat(REGULARISATION * size, 3))).tocsr()


def largest_eigenvalue(matrix: Any) -> float:
    """That of the matrix after its block Jacobi preconditioner, to a percent."""
    half = block_diagonal(np.linalg.inv(np.linalg.cholesky(diagonal_blocks(matrix))))
    start = np.random.default_rng(0).standard_normal(matrix.shape[0])
    scaled = half @ matrix @ half.T
    return float(eigsh(scaled, k=1, v0=start, tol=1e-2, return_eigenvectors=False)[0])


def _smooth(system: StepSystem, motions: Any) -> Any:
    """A damped Jacobi step towards less energy (smoothed aggregation, Vanek et al. 1996)."""
    relaxed = inverse_diagonal(system.rest) @ (system.rest @ motions)
    return motions - 4.0 / 3.0 / largest_eigenvalue(system.rest) * relaxed


def additive(system: StepSystem) -> CandidatePreconditioner:
    """Block Jacobi plus the coarse correction, side by side."""
    coarse = coarse_space(system)
    inverse = inverse_diagonal(system.matrix)
    n = system.nodes
    return CandidatePreconditioner(
        apply=lambda r: inverse @ r + coarse.correct(r),
        touched=n + coarse.touched,
        stored=n + coarse.stored,
        renewed=BLOCK_PRODUCT * n,
    )


def between_jacobi(system: StepSystem) -> CandidatePreconditioner:
    """A coarse correction between two damped Jacobi sweeps."""
    coarse, matrix = coarse_space(system), system.matrix
    inverse = 4.0 / 3.0 / largest_eigenvalue(system.rest) * inverse_diagonal(matrix)

    def apply(r: FloatArray) -> FloatArray:
        z: FloatArray = inverse @ r
        z = z + coarse.correct(r - matrix @ z)
        corrected: FloatArray = z + inverse @ (r - matrix @ z)
        return corrected

    n = system.nodes
    return CandidatePreconditioner(
        apply=apply,
        touched=2.0 * (system.blocks + n) + coarse.touched,
        stored=n + coarse.stored,
        renewed=BLOCK_PRODUCT * n,
    )


def between_gauss_seidel(
    system: StepSystem, *, smoothed: bool = False, present: bool = False
) -> CandidatePreconditioner:
    """A coarse correction between a forward and a backward Gauss-Seidel sweep: the engine's.

    After a forward sweep from zero the residual is made of what stands above the diagonal, so the
    sweep and the residual touch each block once; the backward sweep touches each once more.
    """
    coarse, matrix = coarse_space(system, smoothed=smoothed, present=present), system.matrix
    forward, backward = sweeps(matrix)

    def apply(r: FloatArray) -> FloatArray:
        z = forward(r)
        z = z + coarse.correct(r - matrix @ z)
        return z + backward(r - matrix @ z)

    n = system.nodes
    renewed = BLOCK_PRODUCT * n
    if present:
        renewed += BLOCK_PRODUCT * GALERKIN_PRODUCTS * system.blocks + coarse.factor.price
    return CandidatePreconditioner(
        apply=apply,
        touched=2.0 * system.blocks + coarse.touched,
        stored=n + coarse.stored,
        renewed=renewed,
    )
