"""Codes that solvers and contact share, and the slots of their counters and scalars."""

from enum import IntEnum


class VelocityConstraint(IntEnum):
    """Which components of a node's velocity are given; the others are solved for."""

    NONE = 0
    PLANE = 1
    """The component along the node's axis is given, the normal of a plane that it slides on."""
    FIXED = 2
    """All three are given."""
    LINE = 3
    """Only the component along the node's axis is free."""


class Counter(IntEnum):
    """Slots of the counters (int32) of a step's solves and contact passes."""

    ITERATIONS = 0
    """Of the present solve."""
    CONDITION = 1
    """Whether the present solve goes on."""
    TOTAL_ITERATIONS = 2
    """Of all solves of the step."""
    UNCONVERGED = 3
    """Solves of the step that ended above their tolerance."""
    PASSES = 4
    """Active-set passes since the last Newton iteration began."""
    AGAIN = 5
    """Whether another pass is due."""
    TOUCHING = 6
    """Nodes and pairs in contact."""
    LOOSE = 7
    """Whether the next solve only serves to choose contact modes."""
    CHANGED = 8
    """Nodes and pairs that the last pass changed."""
    EARLIER_PASSES = 9
    """Passes of the earlier Newton iterations of the step."""
    FRICTION_NEXT = 10
    """Whether the next pass chooses friction anew."""
    FAILED = 11
    """Whether the last solve did not converge."""


class Scalar(IntEnum):
    """Slots of the scalars (float64) of a solve; residuals are impulses, so squares are (N s)^2."""

    RESIDUAL_PRODUCT = 0
    """r . z of the iteration before."""
    TARGET_SQUARE = 1
    """Of the residual that a tight solve stops at."""
    LAST_SQUARE = 2
    """Of the present residual."""
    STOP_SQUARE = 3
    """Of the residual that the present solve stops at."""
    NEW_PRODUCT = 4
    """r . z of the present iteration."""
    CURVATURE = 5
    """p . M~ p."""
    FLOOR_SQUARE = 6
    """Of the residual below which no solve needs to go."""
    WHOLE_SQUARE = 7
    """Of the tolerance times the whole momentum."""
    CHANGE_SQUARE = 8
    """Of the tolerance times what the step changes."""


class BlockCounter(IntEnum):
    """Slots of the counters (int32) of a solve in blocks of right-hand sides."""

    ITERATIONS = 0
    """Of the present solve."""
    CONDITION = 1
    """Whether the solve goes on."""
