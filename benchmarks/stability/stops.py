"""Cases of the stability suite that have to end: numbers that are none, and what is said then."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np

from benchmarks.stability import bodies
from warp_softbody import Push, Scene, Simulation, SimulationOptions, Stepper, TetMesh, build_model
from warp_softbody.engine.state import Contacts, Control, State
from warp_softbody.errors import InputError, NotFiniteError
from warp_softbody.world.frame import Frame

TIME_STEP = 0.01
FPS = 100.0
"""A frame every step."""

PUSHED_STEP = 10
HUGE = 1e25
"""A force, N, whose square is beyond single precision."""


@dataclass(frozen=True, kw_only=True)
class Ending:
    """How an attempt ended.

    Attributes:
        said: the error, or the status.
        failed: what was wrong with that, or None.
    """

    said: str
    failed: str | None = None


@dataclass(frozen=True, kw_only=True)
class Stop:
    """One row of the table: an attempt that has to end, made under options."""

    name: str
    extreme: str
    attempt: Callable[[dict[str, Any]], Ending]


def _frames(scene: Scene, overrides: dict[str, Any]) -> tuple[list[Frame], NotFiniteError | None]:
    """Frames of 20 steps, or those before the error."""
    options = SimulationOptions(**{"time_step": TIME_STEP, **overrides})
    simulation = Simulation(scene, options=options, fps=FPS)
    frames: list[Frame] = []
    try:
        for frame in simulation.run(2.0 * PUSHED_STEP * TIME_STEP):
            frames.append(frame)
    except NotFiniteError as error:
        return frames, error
    return frames, None


def huge_push(overrides: dict[str, Any]) -> Ending:
    """A push beyond all numbers from step 10 on; frames before it are those of a body in peace."""
    character = bodies.body(bodies.bar_mesh(), clamped=False)
    start = PUSHED_STEP * TIME_STEP
    push = Push(region="all", force=(HUGE, 0.0, 0.0), start=start, duration=start)
    with np.errstate(over="ignore"):
        frames, error = _frames(Scene(character=character, pushes=(push,)), overrides)
    if error is None:
        return Ending(said="goes on", failed="no error")
    said = f"error at step {error.step}, {len(frames)} frames kept"
    peaceful, _ = _frames(Scene(character=character), overrides)
    kept = [
        frame.positions.tobytes() == other.positions.tobytes()
        for frame, other in zip(frames, peaceful, strict=False)
    ]
    if error.step != PUSHED_STEP or len(frames) != PUSHED_STEP + 1:
        return Ending(said=said, failed=f"{said}, not at step {PUSHED_STEP}")
    if not all(kept):
        return Ending(said=said, failed="frames before the push differ from those without it")
    return Ending(said=said)


def poisoned_state(overrides: dict[str, Any]) -> Ending:
    """One coordinate of one free node that is no number; the step's status has to tell."""
    character = bodies.body(bodies.bar_mesh())
    options = SimulationOptions(**{"time_step": TIME_STEP, **overrides})
    model = build_model(Scene(character=character), options)
    for array in ("positions", "velocities"):
        state, after = State.at_rest(model), State.at_rest(model)
        values = getattr(state, array).numpy()
        values[-1, 2] = np.nan
        getattr(state, array).assign(values)
        stepper, contacts = Stepper(model), Contacts.none(model)
        if stepper.step(state, Control.slack(model), contacts, after).finite:
            return Ending(said="goes on", failed=f"a NaN among the {array} is not noticed")
    return Ending(said="status of the first step")


def refused_input(overrides: dict[str, Any]) -> Ending:
    """NaN or infinity in a mesh, a push, gravity or a velocity."""
    del overrides
    mesh = bodies.bar_mesh()
    points = mesh.points.copy()
    points[7, 1] = np.nan
    body = bodies.body(mesh)
    inf = float("inf")
    attempts: dict[str, Callable[[], object]] = {
        "mesh": lambda: TetMesh.from_arrays(points, mesh.tets),
        "push": lambda: Push(region="all", force=(inf, 0.0, 0.0), start=0.0, duration=1.0),
        "gravity": lambda: Scene(character=body, gravity=(0.0, 0.0, -inf)),
        "velocity": lambda: Scene(character=body, initial_velocity=(float("nan"), 0.0, 0.0)),
        "time step": lambda: SimulationOptions(time_step=inf),
    }
    for name, attempt in attempts.items():
        try:
            attempt()
        except InputError:
            continue
        return Ending(said="accepted", failed=f"a {name} that is not finite is accepted")
    return Ending(said="refused in one sentence")


STOPS: tuple[Stop, ...] = (
    Stop(name="huge push", extreme="a push of 1e25 N in step 10, free bar", attempt=huge_push),
    Stop(name="NaN state", extreme="a NaN in the state", attempt=poisoned_state),
    Stop(name="NaN input", extreme="NaN or infinity in what is given", attempt=refused_input),
)
