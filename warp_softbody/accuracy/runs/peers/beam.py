"""A beam clamped at one end that falls under its own weight, as peers are given it."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from warp_softbody.arrays import FloatArray
from warp_softbody.body.material import Material
from warp_softbody.body.mesh import TetMesh

GRAVITY = 9.81
MATERIAL = Material(
    young_modulus=1e6, poisson_ratio=0.4, density=1000.0, stiffness_damping=0.0, mass_damping=0.0
)


@dataclass(frozen=True, kw_only=True)
class Cantilever:
    """A mesh with its clamped and its tip face.

    Attributes:
        mesh: the straight beam along x.
        fixed: (n,) whether a node is clamped.
        tip: (n,) whether a node is on the free end face.
    """

    mesh: TetMesh
    fixed: npt.NDArray[np.bool_]
    tip: npt.NDArray[np.bool_]

    def fall(self, positions: FloatArray) -> float:
        """Mean fall of the tip face, m."""
        return float((self.mesh.points - positions)[self.tip, 2].mean())


@dataclass(frozen=True, kw_only=True)
class StepReport:
    """What one step says about itself.

    Attributes:
        iterations: of the linear solver, None where it has none or does not tell.
        converged: whether the linear solve reached its tolerance.
        solve_ms: the part of the step that is the linear solve, where it stands apart.
        residual: the linear solve's relative residual in the solver's own words.
    """

    iterations: int | None = None
    converged: bool = True
    solve_ms: float | None = None
    residual: float | None = None
