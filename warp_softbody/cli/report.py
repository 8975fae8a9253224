"""The summary of a run, for programs and for people."""

from __future__ import annotations

import json
from collections.abc import Mapping
from typing import Any

from warp_softbody.statistics import PARTS, RunSummary


def as_json(summary: RunSummary, more: Mapping[str, Any]) -> str:
    """One JSON object on one line; strict JSON, so no NaN."""
    return json.dumps({**summary.to_dict(), **more}, allow_nan=False)


def as_text(summary: RunSummary, more: Mapping[str, Any], *, asked_time_step: float) -> str:
    """A few aligned lines."""
    head = f"{summary.scene}: {summary.simulated_seconds:.4g} s in {summary.frames} frames"
    lines = [
        ("real time", _real_time(summary)),
        ("step", _step(summary)),
        ("parts", _parts(summary)),
        ("body", _body(summary)),
        ("solves", _solves(summary)),
    ]
    if summary.time_step < asked_time_step * (1.0 - 1e-9):
        lines.append(("time step", _shortened(summary, asked_time_step, more["fps"])))
    if summary.unconverged_steps:
        lines.append(("unconverged", f"{summary.unconverged_steps} steps"))
    paths = {"stage": summary.stage, "picture": more["picture"], "movie": more["movie"]}
    lines += [(name, path) for name, path in paths.items() if path]
    body = [f"  {name:<12}{text}" for name, text in lines]
    return "\n".join([f"{head}, {summary.status}", *body])


def _real_time(summary: RunSummary) -> str:
    return (
        f"{summary.real_time_factor:.2f} simulated s per wall s "
        f"({summary.wall_seconds:.3g} s, after {summary.setup_seconds:.2g} s of setup)"
    )


def _step(summary: RunSummary) -> str:
    spread = summary.step_ms["all"]
    return (
        f"{spread.median:.2f} ms median, {spread.p95:.2f} ms p95, "
        f"for {1e3 * summary.time_step:.4g} ms of motion"
    )


def _parts(summary: RunSummary) -> str:
    medians = [f"{part} {summary.step_ms[part].median:.2f}" for part in PARTS]
    return f"{', '.join(medians)} ms (medians)"


def _body(summary: RunSummary) -> str:
    return (
        f"{summary.tets} tets, {summary.nodes} nodes, {summary.segments} muscle segments, "
        f"{summary.patches} patches"
    )


def _solves(summary: RunSummary) -> str:
    return (
        f"{summary.qps_per_step.mean:.1f} QPs and {summary.cg_iterations.mean:.1f} conjugate "
        "gradient iterations a step (means)"
    )


def _shortened(summary: RunSummary, asked: float, fps: float) -> str:
    steps = round(1.0 / (fps * summary.time_step))
    return (
        f"{1e3 * summary.time_step:.4g} ms, shortened from {1e3 * asked:.4g} ms "
        f"to fit {steps} steps into a frame"
    )
