"""What a step gives back to the spin of a body that nothing touches, as part of its linear maps.

The step adds the turn omega x r that leaves the body the angular momentum of its known impulses
(`kernels.rigid_balance`): ``v+ = y + R I^-1 (X b - X M~' y)`` with ``M~ y = b``, R the turns of the
nodes about the centre of mass, X = R^T the moments of impulses on them, M~' the damped masses and
I = X M~' R. So J v+ = (J - C X M~') y + C X b with C = J R I^-1.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from warp_softbody.arrays import FloatArray


@dataclass(frozen=True)
class FreeTurn:
    """The balance of a free body's angular momentum, for rows J (r, 3n).

    Attributes:
        rows: what is left of J for the solve, (r, 3n): it takes every turn to zero.
        responses: C X, (r, 3n): what the turn answers to impulses.
    """

    rows: FloatArray
    responses: FloatArray

    @staticmethod
    def of(rows: FloatArray, positions: FloatArray, masses: FloatArray) -> FreeTurn:
        """For nodes at ``positions`` (n, 3), m, with damped masses (n,), kg."""
        arms = positions - masses @ positions / masses.sum()
        # v = omega x r at each node: column k of the turns is e_k x r
        turns = np.cross(np.eye(3)[:, None, :], arms[None, :, :]).reshape(3, -1)
        moments = turns * np.repeat(masses, 3)
        inertia = moments @ turns.T
        shares = np.linalg.solve(inertia, turns @ rows.T).T
        return FreeTurn(rows=rows - shares @ moments, responses=shares @ turns)
