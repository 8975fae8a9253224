"""Time courses that the motions share: a smooth step, and a cost that decays to its usual value.

A share of an interval of time runs from 0 at its start to 1 at its end.
"""

from __future__ import annotations

from warp_softbody.controllers.controller import ActivationCost
from warp_softbody.inputs.records import unchecked_copy


def smooth_step(share: float) -> tuple[float, float, float]:
    """The quintic minimum-jerk step from 0 to 1 and its first two derivatives by the share.

    Velocity and acceleration vanish at both ends; beyond them the step stays at 0 and at 1 (Flash
    and Hogan, The coordination of arm movements, 1985).
    """
    t = min(max(share, 0.0), 1.0)
    step = t**3 * (10.0 - 15.0 * t + 6.0 * t**2)
    return step, 30.0 * t**2 * (1.0 - t) ** 2, 60.0 * t * (1.0 - t) * (1.0 - 2.0 * t)


def way_on(
    place: float, speed: float, goal: float, seconds: float, share: float
) -> tuple[float, float]:
    """Place and speed at a share of the seconds in which something that moves comes to rest.

    The quintic that begins at ``place`` with ``speed`` and no acceleration, and ends at ``goal``
    without either; before its start it is where it begins, after its end at the goal.
    """
    t = min(max(share, 0.0), 1.0)
    step, rate, _ = smooth_step(t)
    glide = t * (1.0 - t) ** 3 * (1.0 + 3.0 * t)
    slowing = (1.0 - t) ** 2 * (1.0 + 2.0 * t - 15.0 * t**2)
    way = goal - place
    return place + step * way + glide * seconds * speed, rate / seconds * way + slowing * speed


def eased_change(usual: ActivationCost, ease: float, share: float) -> ActivationCost:
    """The usual cost, with a change ``1 + ease (1 - share)^2`` times as expensive until share 1.

    After a contact was lost or won the other ones so take over the load in several steps.
    """
    left = max(0.0, 1.0 - share)
    return unchecked_copy(usual, change=usual.change * (1.0 + ease * left**2))
