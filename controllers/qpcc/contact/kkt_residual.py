"""The KKT residual of a minimiser on chosen contact modes, apart from the QP that gave it."""

from __future__ import annotations

import numpy as np

from warp_softbody.arrays import FloatArray
from warp_softbody.controllers.qpcc.contact.mode_minimiser import ModeMinimiser
from warp_softbody.controllers.qpcc.contact.mode_qp import ScaledContactQPCC, per_contact

AT_BOUND = 1e-9
"""Scaled distance from a bound up to which a control is at it."""


def kkt_residual(
    scaled: ScaledContactQPCC, minimiser: ModeMinimiser
) -> tuple[FloatArray, FloatArray, float]:
    """Multipliers (K, 6) of the contacts and (nu,) of the bounds, and the residual, scaled.

    They are computed anew from the point and its velocity multipliers. The residual is the
    largest of: gradient in controls off their bounds, or of a wrong sign at them; negative
    derivatives along rays of the chosen cones; products of contact multipliers and (f, w).
    """
    nu, force = len(scaled.lower), minimiser.points[:, :3].reshape(-1)
    on_velocity = minimiser.multipliers[:, 3:].reshape(-1)
    z = np.concatenate([minimiser.controls, force])
    gradient = scaled.objective.times(z) + scaled.objective.c
    multipliers = per_contact(gradient[nu:] - on_velocity @ scaled.delassus, on_velocity)
    rest = gradient[:nu] - on_velocity @ scaled.free_velocity[:, 1:]
    at_lower = minimiser.controls <= scaled.lower + AT_BOUND
    at_upper = minimiser.controls >= scaled.upper - AT_BOUND
    off = np.where(at_lower, np.minimum(rest, 0.0), rest)
    off = np.where(at_upper, np.maximum(off, 0.0), off)
    worst = float(np.abs(off).max(initial=0.0))
    if len(minimiser.modes):
        rays = scaled.table.rays[np.arange(len(minimiser.modes)), minimiser.modes]
        along = rays @ multipliers[:, :, None]
        products = np.abs((multipliers * minimiser.points).sum(axis=1))
        worst = max(worst, -float(along.min()), float(products.max()))
    return multipliers, rest, worst
