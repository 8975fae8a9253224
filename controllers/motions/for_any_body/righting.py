"""What turns a body back to the orientation that it had at rest."""

from __future__ import annotations

import math

import numpy as np

from warp_softbody.arrays import FloatArray
from warp_softbody.controllers.motions.body_measures import moments_of_inertia
from warp_softbody.world.view import BodyView


def righting(
    view: BodyView, turn: float, spin: float, *, yaw: float = 0.0, turning: float = 0.0
) -> FloatArray:
    """Rate of angular momentum (3,) N m by which the body comes back to its rest orientation.

    ``sum m a x r`` of the arms a at rest and r now is, of a body that has turned by a small vector,
    that vector times moments of inertia.

    Args:
        view: of this step.
        turn: 1/s^2, of what it has turned.
        spin: 1/s, decay of the angular momentum that it has.
        yaw: rad, about the vertical, by which it is to be turned from the rest orientation.
        turning: rad/s, at which it is to turn.
    """
    arms, loads = view.kept("arms at rest", lambda: _arms(view))
    positions = view.positions[: len(arms)]
    if yaw:
        c, s = math.cos(yaw), math.sin(yaw)
        arms = arms @ np.array([[c, s, 0.0], [-s, c, 0.0], [0.0, 0.0, 1.0]])
        loads = view.masses[: len(arms), None] * arms
    moments = loads.T @ (positions - view.center_of_mass)
    across = moments - moments.T
    turned = np.array([across[1, 2], across[2, 0], across[0, 1]])
    rate = -turn * turned - spin * view.angular_momentum
    if turning:
        rate[2] += spin * turning * moments_of_inertia(view)[2]
    return np.asarray(rate)


def _arms(view: BodyView) -> tuple[FloatArray, FloatArray]:
    """Places (n, 3) m of the nodes at rest about their centre of mass, and masses times these."""
    rest = view.scene.character.mesh.points
    masses = view.masses[: len(rest)]
    arms = rest - masses @ rest / view.mass
    return arms, masses[:, None] * arms
