"""Preconditioners without a coarse space: diagonals, sweeps, incomplete and whole factors."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from benchmarks.preconditioners.factors import (
    BLOCK_PRODUCT,
    factorise,
    incomplete_ldl,
    sweeps,
    triangular_solver,
)
from benchmarks.preconditioners.system import Apply, StepSystem, block_diagonal, diagonal_blocks


@dataclass(frozen=True, kw_only=True)
class CandidatePreconditioner:
    """An approximate inverse and its price, counted in 3 x 3 blocks.

    Attributes:
        apply: residual to correction, symmetric and positive definite.
        touched: blocks that are multiplied by a vector in one application.
        stored: blocks kept besides the matrix.
        renewed: work that every new step's matrix asks for, in blocks multiplied by a vector.
    """

    apply: Apply
    touched: float
    stored: float
    renewed: float


def identity(system: StepSystem) -> CandidatePreconditioner:
    """None at all."""
    return CandidatePreconditioner(apply=np.copy, touched=0.0, stored=0.0, renewed=0.0)


def point_jacobi(system: StepSystem) -> CandidatePreconditioner:
    """Each equation by its own diagonal entry."""
    inverse = 1.0 / system.matrix.diagonal()
    # a vector of 3 n numbers is n / 3 blocks
    third = system.nodes / 3.0
    return CandidatePreconditioner(
        apply=lambda r: inverse * r, touched=third, stored=third, renewed=third
    )


def block_jacobi(system: StepSystem) -> CandidatePreconditioner:
    """Each node by its own diagonal block."""
    inverse = inverse_diagonal(system.matrix)
    n = float(system.nodes)
    return CandidatePreconditioner(
        apply=lambda r: inverse @ r, touched=n, stored=n, renewed=BLOCK_PRODUCT * n
    )


def gauss_seidel(system: StepSystem) -> CandidatePreconditioner:
    """A forward and a backward sweep over the nodes."""
    n = float(system.nodes)
    forward, backward = sweeps(system.matrix)
    pivots = block_diagonal(diagonal_blocks(system.matrix))
    return CandidatePreconditioner(
        apply=lambda r: backward(pivots @ forward(r)),
        touched=float(system.blocks),
        stored=n,
        renewed=BLOCK_PRODUCT * n,
    )


def incomplete_factor(system: StepSystem) -> CandidatePreconditioner:
    """L D L^T on the pattern of the matrix, nodes in the mesh's order."""
    lower, pivots, updates = incomplete_ldl(system.matrix)
    forward = triangular_solver(lower.tocsc())
    backward = triangular_solver(lower.T.tocsc())
    inverse = block_diagonal(np.linalg.inv(pivots))
    n, below = system.nodes, (system.blocks - system.nodes) / 2.0
    return CandidatePreconditioner(
        apply=lambda r: backward(inverse @ forward(r)),
        touched=2.0 * below + n,
        stored=below + n,
        renewed=BLOCK_PRODUCT * (updates + below + n),
    )


def present_factor(system: StepSystem) -> CandidatePreconditioner:
    """The whole factor of the matrix itself."""
    factor = factorise(system.matrix)
    return CandidatePreconditioner(
        apply=factor.solve,
        touched=factor.touched,
        stored=factor.stored,
        renewed=factor.price,
    )


def rest_factor(system: StepSystem) -> CandidatePreconditioner:
    """The whole factor of the rest shape's matrix, turned with the nodes."""
    factor = factorise(system.rest)
    turns = block_diagonal(system.rotations)
    back = turns.T.tocsr()
    n = system.nodes
    return CandidatePreconditioner(
        apply=lambda r: turns @ factor.solve(back @ r),
        touched=factor.touched + 2.0 * n,
        stored=factor.stored + n,
        renewed=0.0,
    )


def inverse_diagonal(matrix: Any) -> Any:
    """CSR matrix of the inverses of the diagonal's 3 x 3 blocks."""
    return block_diagonal(np.linalg.inv(diagonal_blocks(matrix)))
