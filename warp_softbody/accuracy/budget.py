"""How many QPs the controller's search may solve in a step, as a knob."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import replace

from warp_softbody.controllers import driver


@contextmanager
def qp_budget(most: int | None) -> Iterator[None]:
    """Inside the body, a step solves at most so many; None leaves it as shipped."""
    shipped = driver.STEP_OPTIONS, driver.CALM_OPTIONS
    if most is not None:
        driver.STEP_OPTIONS, driver.CALM_OPTIONS = (
            replace(options, max_qps=most) for options in shipped
        )
    try:
        yield
    finally:
        driver.STEP_OPTIONS, driver.CALM_OPTIONS = shipped
