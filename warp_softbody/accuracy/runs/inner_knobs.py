"""Knobs of the engine that are no option of a simulation: constants, set while a run is made."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import ExitStack, contextmanager
from dataclasses import replace
from types import ModuleType
from typing import TYPE_CHECKING, Any

import numpy as np
import numpy.typing as npt

from warp_softbody.accuracy.cases.settings import Settings
from warp_softbody.controllers import control_solver as driver
from warp_softbody.controllers.qpcc.contact.problem import ContactQPCC, uniform_directions
from warp_softbody.engine import linear_system

if TYPE_CHECKING:
    from warp_softbody.controllers.controller import Goals
    from warp_softbody.engine.reduced_dynamics import ControlProblem

BLOCKS = {"factor": 10**9, "two-level": 0}
"""Most blocks of the factor that preconditions a body, by preconditioner."""


@contextmanager
def inner_knobs(settings: Settings) -> Iterator[None]:
    """Inside the body they are as in the settings; where these say None, as shipped."""
    with ExitStack() as stack:
        if settings.qps is not None:
            for name in ("STEP_OPTIONS", "CALM_OPTIONS"):
                options = replace(getattr(driver, name), max_qps=settings.qps)
                stack.enter_context(_set(driver, name, options))
        if settings.plan_cone is not None:
            stack.enter_context(_set(driver, "build_qpcc", _planned_with(settings.plan_cone)))
        if settings.preconditioner is not None:
            blocks = BLOCKS[settings.preconditioner]
            stack.enter_context(_set(linear_system, "MOST_FACTOR_BLOCKS", blocks))
        yield


@contextmanager
def _set(module: ModuleType, name: str, value: Any) -> Iterator[None]:
    shipped = getattr(module, name)
    setattr(module, name, value)
    try:
        yield
    finally:
        setattr(module, name, shipped)


def _planned_with(directions: int) -> Any:
    """`driver.build_qpcc` with every so manieth of its friction cones' directions."""
    build = driver.build_qpcc

    def built(
        goals: Goals,
        problem: ControlProblem,
        activations: npt.NDArray[np.float64],
        time_step: float,
    ) -> ContactQPCC:
        qpcc = build(goals, problem, activations, time_step)
        stride = len(qpcc.directions) // directions
        return replace(
            qpcc, directions=uniform_directions(directions), factors=qpcc.factors[:, ::stride]
        )

    return built
