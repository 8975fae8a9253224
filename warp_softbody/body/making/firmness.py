"""A material that is firm enough for a body's shape to stand, and muscles strong enough for it."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from warp_softbody.body.making.limbs import Limb
from warp_softbody.body.making.sagging import yielding
from warp_softbody.body.making.shape_regions import SOLE
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

SAG, SWAY = 0.01, 0.125
"""Of the height of the centre of mass, by which its own weight moves it down, and would aside: a
body that yields more is shaken by its own control, or falls off its legs."""

MOST_TIMES = 8.0
"""Times the modulus by `OWN_WEIGHT` that sagging and swaying ask for at most: what stands on a
point sways however firm it is."""

DAMPING = 0.011
"""Stiffness damping over the time sqrt(h / g) of a body of height h, that of the same letter."""

STRENGTH = 0.67
"""Of muscles, over Young's modulus."""

POISSON_RATIO = 0.475
"""Of flesh, nearly, whose volume muscles hardly change."""


def firm_material(
    mesh: TetMesh, limbs: Sequence[Limb], *, density: float, on_feet: bool
) -> Material:
    """A material in which the body stands, kg/m^3 of ``density``, z up and the floor at z = 0.

    Legs, which a body ``on_feet`` has, are not to yield, whichever way they go; a body on one sole
    or a rim has to bend where it goes.
    """
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
    if on_feet:
        most = MOST_TIMES * OWN_WEIGHT * density * GRAVITY * height
        modulus = max(modulus, min(_holding(mesh, weight), most))
    return Material(
        young_modulus=_rounded(modulus),
        poisson_ratio=POISSON_RATIO,
        density=density,
        stiffness_damping=_rounded(DAMPING * float(np.sqrt(height / GRAVITY))),
        volume="exact",
    )


def _holding(mesh: TetMesh, weight: float) -> float:
    """Young's modulus, Pa, with which a body sags and sways no more than it may."""
    held = np.zeros(len(mesh.points), dtype=bool)
    skin = mesh.surface_nodes
    held[skin] = mesh.points[skin, 2] < SOLE * float(mesh.points[:, 2].max())
    spread = mesh.points[held] - mesh.points[held].mean(axis=0)
    if np.linalg.matrix_rank(spread, tol=1e-3 * float(mesh.points[:, 2].max())) < 2:
        # points in a row hold nothing from turning about them
        return 0.0
    found = yielding(mesh, held, POISSON_RATIO, weight)
    return max(found.sag / SAG, found.sway / SWAY) / found.height


def _carries(limb: Limb, height: float) -> bool:
    """Whether a limb comes down to the floor and is steep."""
    rise = float(np.ptp(limb.axis[:, 2]))
    return bool(limb.axis[:, 2].min() < 0.2 * height) and rise > 0.5 * limb.length


def _rounded(value: float) -> float:
    """Two digits, since a third would say more than is known."""
    return float(f"{value:.2g}")
