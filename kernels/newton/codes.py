"""Limits of the step control of Newton's method, and the slots of its counters and scalars."""

from enum import IntEnum

MOST_HALVINGS = 6
"""Of one iteration; a step that must be shorter still has no direction that leads on."""

SUFFICIENT = 1e-4
"""Share of the reduction that linear equations would have, which a step has to reach."""


MOST_OF_DRIFT = 4.0
"""Of what a step that stops all deformation leaves, the most that any iterate may leave."""


class NewtonCount(IntEnum):
    """Slots of the counters (int32) of the control."""

    GO_ON = 0
    """Whether another iteration is due."""
    HALVE = 1
    """Whether the present step is too long."""
    HALVED = 2
    """Halvings of the present iteration."""
    ITERATION = 3
    """Number of the present iteration, from 0 on."""
    STALLED = 4
    """Whether the present iteration has failed."""
    DIVERGED = 5
    """Whether the iterations ended with more than the base of the first one leaves."""
    DRIFTS = 6
    """Whether the base of the first iterate is a drift, in which no body deforms."""
    ALL_HALVINGS = 7
    """Of the time step."""
    ALL_STALLS = 8
    """Of the time step: iterations that no fraction of their step served."""


class NewtonScalar(IntEnum):
    """Slots of the scalars (float64) of the control, roots of merits, J^(1/2)."""

    ACCEPTED = 0
    """Of the last iterate that was accepted."""
    LEFT = 1
    """What the linear solve has left over."""
    BASE = 2
    """Of the base of the first iterate, as its equations are linearised."""
    SHARE = 3
    """Of these impulses that may be true."""
    DRIFT = 4
    """Of a drift, which leaves momenta and forces of deformation, and nothing else."""
