"""The options of a run, made to fit its frames, its scene and its controller."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from warp_softbody.controllers.control_options import ControlOptions, Method
from warp_softbody.engine.option_choice import with_choices
from warp_softbody.engine.options import SimulationOptions
from warp_softbody.inputs import checks
from warp_softbody.world.scene import Scene

LEAST_FPS, MOST_FPS = 1e-3, 1e6
"""Frames a second, the range that is taken for what was meant."""


def whole_steps(time_step: float, fps: float) -> tuple[int, float]:
    """Steps per frame and the time step that fills a frame with them, at most the one asked for."""
    fps = checks.number("fps", fps, low=LEAST_FPS, high=MOST_FPS, unit="1/s")
    steps = max(1, int(np.ceil(1.0 / (fps * time_step) - 1e-6)))
    return steps, 1.0 / (fps * steps)


@dataclass(frozen=True, kw_only=True)
class RunSettings:
    """What a simulation runs with.

    Attributes:
        options: of the engine; the precision is chosen, and the time step fills a frame.
        control_options: of the control solver.
        steps_per_frame: whole.
    """

    options: SimulationOptions
    control_options: ControlOptions
    steps_per_frame: int

    @staticmethod
    def of(
        options: SimulationOptions | None,
        control_options: ControlOptions | None,
        *,
        scene: Scene,
        controlled: bool,
        time_step: float | None,
        fps: float,
        method: Method | None,
    ) -> RunSettings:
        """Checked options; ``time_step`` (s) and ``method`` override those of the options."""
        options = checks.optional("options of a Simulation", options, SimulationOptions)
        control = checks.optional(
            "control_options of a Simulation", control_options, ControlOptions
        )
        # made anew, so that what went round a constructor is checked too
        options = replace(options, time_step=options.time_step if time_step is None else time_step)
        control = replace(control, method=control.method if method is None else method)
        steps, step = whole_steps(options.time_step, fps)
        options = with_choices(replace(options, time_step=step), scene)
        # what a controller decides hangs on digits
        tolerance = options.solver_tolerance if controlled else options.tolerance
        options = replace(options, tolerance=tolerance)
        return RunSettings(options=options, control_options=control, steps_per_frame=steps)
