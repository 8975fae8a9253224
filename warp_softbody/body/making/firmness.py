"""A material that is firm enough for a body's shape to stand, and muscles strong enough for it."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from warp_softbody.body.making.limbs import Limb
from warp_softbody.body.material import Material
from warp_softbody.body.mesh import TetMesh

GRAVITY = 9.81
"""m/s^2, in which the body is to stand."""

OWN_WEIGHT = 180.0
"""Young's modulus over the pressure of a column as high as the body: that of the shipped letter
that balances."""

MOST_STRAIN = 0.006
"""Of the limbs that carry the body, under its weight."""

BUCKLING = 3.0
"""Times its weight that the limbs would bear before they buckled as columns that are free above."""

DAMPING = 0.011
"""Stiffness damping over the time sqrt(h / g) of a body of height h, that of the same letter."""

STRENGTH = 0.67
"""Of muscles, over Young's modulus."""

POISSON_RATIO = 0.475
"""Of flesh, nearly, whose volume muscles hardly change."""


def firm_material(mesh: TetMesh, limbs: Sequence[Limb], *, density: float) -> Material:
    """A material in which the body stands, kg/m^3 of ``density``, z up and the floor at z = 0."""
    height = float(mesh.points[:, 2].max())
    weight = density * mesh.volume * GRAVITY
    carrying = [limb for limb in limbs if _carries(limb, height)]
    modulus = OWN_WEIGHT * density * GRAVITY * height
    if carrying:
        # Of a round section: half the square of its radius is the square of the mean distance.
        areas = np.array([2.0 * np.pi * limb.radius**2 for limb in carrying])
        inertia = float((areas**2 / (4.0 * np.pi)).sum())
        length = max(float(np.ptp(limb.axis[:, 2])) for limb in carrying)
        modulus = max(modulus, weight / (MOST_STRAIN * float(areas.sum())))
        modulus = max(modulus, BUCKLING * weight * 4.0 * length**2 / (np.pi**2 * inertia))
    return Material(
        young_modulus=_rounded(modulus),
        poisson_ratio=POISSON_RATIO,
        density=density,
        stiffness_damping=_rounded(DAMPING * float(np.sqrt(height / GRAVITY))),
        volume="exact",
    )


def _carries(limb: Limb, height: float) -> bool:
    """Whether a limb comes down to the floor and is steep."""
    rise = float(np.ptp(limb.axis[:, 2]))
    return bool(limb.axis[:, 2].min() < 0.2 * height) and rise > 0.5 * limb.length


def _rounded(value: float) -> float:
    """Two digits, since a third would say more than is known."""
    return float(f"{value:.2g}")
