"""The path of a swung foot over an edge: up, over and down, so that its sole is not caught."""

from __future__ import annotations

import numpy as np

from warp_softbody.arrays import FloatArray
from warp_softbody.controllers.motions.trajectories import smooth_step

UP, DOWN = 0.4, 0.65
"""Shares of the swing by when a foot is up, and from when on it comes down."""

AHEAD = (0.2, 0.9)
"""Shares between which it goes ahead."""


def stepping_over(
    begin: FloatArray, end: FloatArray, peak: float, share: float
) -> tuple[FloatArray, FloatArray]:
    """Place, m, and velocity, m a swing, of a foot that goes from one place (3,) m to another.

    Args:
        begin: where it leaves the ground.
        end: where it lands.
        peak: m, height that it has from the share `UP` to `DOWN`.
        share: of the swing that is over.
    """
    lasts = AHEAD[1] - AHEAD[0]
    step, rate, _ = smooth_step(float(np.clip((share - AHEAD[0]) / lasts, 0.0, 1.0)))
    place, speed = begin + step * (end - begin), rate / lasts * (end - begin)
    if share < DOWN:
        up, climb, _ = smooth_step(min(share / UP, 1.0))
        place[2], speed[2] = begin[2] + up * (peak - begin[2]), climb / UP * (peak - begin[2])
    else:
        down, fall, _ = smooth_step((share - DOWN) / (1.0 - DOWN))
        place[2] = peak + down * (end[2] - peak)
        speed[2] = fall / (1.0 - DOWN) * (end[2] - peak)
    return place, speed
