"""What the live page costs the program: CPU time and bytes of an update while a scene is run.

    python -m benchmarks.live_page [SCENE ...]

An update is a thirtieth of a simulated second: its steps, and what the page is told of them. A core
that does nothing else gives 30 a second where an update takes less than 33 ms.
"""

from __future__ import annotations

import argparse
import time
from pathlib import Path

import numpy as np

from warp_softbody import scenes
from warp_softbody.controllers.control_options import ControlOptions
from warp_softbody.engine.option_choice import with_choices
from warp_softbody.engine.options import SimulationOptions
from warp_softbody.live.audience import Page
from warp_softbody.live.live_scene import LivePlan, LiveScene
from warp_softbody.live.session import FPS, LiveSession
from warp_softbody.run.warp_session import warp_engine

WARM_UP = 15
UPDATES = 90


def plan_of(name: str) -> LivePlan:
    """A scene as `view` runs it."""
    plan = scenes.make(name)
    options = SimulationOptions(time_step=plan.time_step)
    return LivePlan(
        name=name,
        scene=plan.scene,
        controller=plan.controller,
        options=with_choices(options, plan.scene),
        control=None if plan.controller is None else ControlOptions(),
    )


def next_update(session: LiveSession, page: Page) -> bytes:
    """Let the session go on until the page is told something new."""
    page.update = None
    while page.update is None:
        session.turn()
    return page.update


def measure(name: str) -> tuple[float, float, float]:
    """Median and 95th percentile of the CPU time of an update, ms, and its mean length, bytes."""
    session = LiveSession(LiveScene(lambda: plan_of(name), FPS), Path())
    page = session.audience.enter()
    assert page is not None
    for _ in range(WARM_UP):
        next_update(session, page)
    spent, lengths = [], []
    for _ in range(UPDATES):
        begun = time.process_time()
        lengths.append(len(next_update(session, page)))
        spent.append(1e3 * (time.process_time() - begun))
    low, high = np.percentile(spent, (50, 95))
    return float(low), float(high), float(np.mean(lengths))


def main() -> None:
    """Print a line for each scene."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("scenes", nargs="*", default=["balance-i", "walk-x", "drop-block"])
    names = parser.parse_args().scenes
    print(f"{'scene':20s} {'ms, median':>12s} {'95 %':>8s} {'bytes':>8s}")
    with warp_engine("cpu", lambda: None):
        for name in names:
            median, high, length = measure(name)
            print(f"{name:20s} {median:12.1f} {high:8.1f} {length:8.0f}", flush=True)


if __name__ == "__main__":
    main()
