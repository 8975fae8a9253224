"""The summary of a run is printed for people, or as JSON for programs."""

from __future__ import annotations

import json
from collections.abc import Mapping
from typing import Any

from warp_softbody.run.run_summary import RunSummary, text_table


def as_json(summary: RunSummary, more: Mapping[str, Any]) -> str:
    """One JSON object on one line; strict JSON, so no NaN."""
    return json.dumps({**summary.to_dict(), **more}, allow_nan=False)


def as_text(summary: RunSummary, more: Mapping[str, Any], *, asked_time_step: float) -> str:
    """A few aligned lines."""
    lines = summary.lines()
    if summary.time_step < asked_time_step * (1.0 - 1e-9):
        lines.append(("time step", _shortened(summary, asked_time_step, more["fps"])))
    if summary.unconverged_steps:
        lines.append(("unconverged", _unsettled(summary)))
    files = ("picture", "movie", "plots", "html")
    paths = {"stage": summary.stage, **{name: more[name] for name in files}}
    lines += [(name, path) for name, path in paths.items() if path]
    return text_table(summary.headline, lines)


def _unsettled(summary: RunSummary) -> str:
    worst = summary.findings.unsettled
    told = f"{summary.unconverged_steps} steps"
    if worst is None or worst.force == 0.0:
        return told
    where = f"node {worst.node} of {worst.body!r}" if worst.node >= 0 else f"{worst.body}"
    return (
        f"{told}, the worst at {worst.time:.3f} s: {where} misses its contact law by "
        f"{worst.force:.2g} N"
    )


def _shortened(summary: RunSummary, asked: float, fps: float) -> str:
    steps = round(1.0 / (fps * summary.time_step))
    return (
        f"{1e3 * summary.time_step:.4g} ms, shortened from {1e3 * asked:.4g} ms "
        f"to fit {steps} steps into a frame"
    )
