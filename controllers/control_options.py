"""How a controller's wishes are turned into activations: budgets and accuracy of each step."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Literal, get_args

from warp_softbody.controllers.qpcc.next_minima import OTHERS
from warp_softbody.inputs.option_fields import check_options, described, option
from warp_softbody.inputs.option_kinds import ChoiceKind, NumberKind, WholeKind

Method = Literal["qpcc", "static"]
PlannedCone = Literal[4, 8]
METHODS: tuple[Method, ...] = get_args(Method)
PLANNED_CONES: tuple[PlannedCone, ...] = get_args(PlannedCone)

HORIZON = 0.0522
"""sqrt(L/g), of plans: 1/60 s of a body of 1 m on Earth."""

MOST_HORIZON = 100.0
"""sqrt(L/g): a plan for longer is none of a motion, and its step is too long for an engine."""


@described
@dataclass(frozen=True, kw_only=True)
class ControlOptions:
    """Settings of the control solver, validated on construction; each field describes itself."""

    method: Method = field(
        default="qpcc",
        metadata=option(
            ChoiceKind(METHODS),
            "how activations are found: by the contact QPCC, or by a QP that takes every contact "
            "for static (the baseline of the paper)",
            flag=False,
            knob="method",
            short="",
        ),
    )
    max_qps: int = field(
        default=40,
        metadata=option(
            WholeKind(low=1),
            "QPs of one step",
            knob="qps",
            short="QPs",
        ),
    )
    kicks: int = field(
        default=20,
        metadata=option(
            WholeKind(low=0),
            "how often a step leaves a local minimum by forcing one contact into another mode, or "
            "all to slide the same way; each kick costs up to three QPs",
        ),
    )
    kick_patience: int = field(
        default=3,
        metadata=option(
            WholeKind(low=0),
            "kicks in a row without a better minimum after which a step tries no more",
        ),
    )
    kick_reach: float = field(
        default=3.0,
        metadata=option(
            NumberKind(above=0.0),
            "how far above the best objective, as a share of its size, a kick's first QP may end; "
            "beyond it the kick is given up",
        ),
    )
    carried: int = field(
        default=3,
        metadata=option(
            WholeKind(low=0, high=OTHERS),
            "how many of a step's next best minima the step after it begins from too",
        ),
    )
    kick_pause: int = field(
        default=8,
        metadata=option(
            WholeKind(low=0),
            "steps of unchanged contact modes after which only one step in so many tries kicks; "
            "with 0 every step does",
        ),
    )
    calm_objective: float = field(
        default=0.0,
        metadata=option(
            NumberKind(low=0.0),
            "objective below which the next step goes without kicks; in the units of the shipped "
            "controllers, momentum rows over m g dt, 0.01 is a missing force of a tenth of the "
            "weight; with 0 no step is too calm for kicks",
        ),
    )
    horizon: float = field(
        default=HORIZON,
        metadata=option(
            NumberKind(low=0.0, high=MOST_HORIZON),
            "sqrt(L/g) of the body, time at whose end a plan asks for velocities, to the nearest "
            "whole number of time steps; with 0 it is one step",
        ),
    )
    planned_cone: PlannedCone = field(
        default=8,
        metadata=option(
            ChoiceKind(PLANNED_CONES),
            "directions of the friction cones that a step is planned with",
            knob="plan_cone",
            short="planned cone",
        ),
    )
    response_tolerance: float = field(
        default=1e-3,
        metadata=option(
            NumberKind(above=0.0, below=1.0),
            "relative residual at which the solve for the body's response to the controller's "
            "rows stops",
        ),
    )
    max_response_iterations: int = field(
        default=400,
        metadata=option(
            WholeKind(low=1),
            "iterations of that solve; one that needs more is counted as not converged",
        ),
    )

    def __post_init__(self) -> None:
        """Refuse what no step can be planned with."""
        check_options(self)
