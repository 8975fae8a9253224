"""Which points of all possible ones are run, so that few runs find the frontier."""

from __future__ import annotations

import itertools
from collections.abc import Iterable, Sequence
from dataclasses import dataclass, replace
from typing import Any, TypeVar

from warp_softbody import scenes
from warp_softbody.accuracy.cases.case import TIME_STEPS, ChartCase, Mesh
from warp_softbody.accuracy.cases.settings import Settings
from warp_softbody.accuracy.runs.job import Job

T = TypeVar("T")

REFERENCE_TOLERANCE = 1e-8
WORTH = 0.03
"""Share of the cost or of the error by which a knob has to better the default to be combined."""


@dataclass(frozen=True, kw_only=True)
class Measured:
    """What chooses the combinations: settings with their cost and error."""

    settings: Settings
    cost: float
    error: float


def job(case: ChartCase, settings: Settings, solver: str = "ours") -> Job:
    """The run of a point."""
    return Job(
        scene=case.scene,
        given=case.given,
        seconds=case.seconds,
        functionals=case.functionals,
        settings=settings,
        solver=solver,
    )


def grid(case: ChartCase) -> list[Settings]:
    """Every mesh with every time step; all else as shipped."""
    return [
        replace(case.default, cells=cells, level=level, time_step=step)
        for cells, level in usable_meshes(case)
        for step in case.time_steps
    ]


def singles(case: ChartCase) -> list[Settings]:
    """Each other value of each knob, all else as shipped."""
    return [
        replace(case.default, **{knob: value})
        for knob, values in case.knobs.items()
        for value in values
    ]


def reference_family(case: ChartCase) -> list[Settings]:
    """The finest mesh and the next one, each at every time step down to its last.

    Of a controlled body, whose motions have no limit, the last ones alone: the time step of the
    finest mesh on both, and that of the next one.
    """
    if case.controlled:
        (fine, c), (coarse, s) = case.finest, case.beside
        found = [(coarse, c), (coarse, s), (fine, c)]
        return [reference_settings(case, mesh, step) for mesh, step in dict.fromkeys(found)]
    return [
        replace(reference_settings(case, mesh, last), time_step=step)
        for mesh, last in (case.beside, case.finest)
        for step in TIME_STEPS
        if step >= last
    ]


def reference_settings(case: ChartCase, mesh: Mesh, step: float) -> Settings:
    """In double precision, on one of the meshes of the reference."""
    return Settings(
        time_step=step,
        cells=mesh[0],
        level=mesh[1],
        elements=case.elements,
        tangent=case.default.tangent,
        precision="float64",
        tolerance=REFERENCE_TOLERANCE,
    )


def usable_meshes(case: ChartCase) -> list[Mesh]:
    """Those with cells only where the scene has that setting."""
    has_cells = any(setting.name == "cells" for setting in scenes.recipe(case.scene).settings)
    return [mesh for mesh in case.meshes if has_cells or mesh[0] is None]


def products(case: ChartCase, measured: Sequence[Measured]) -> list[Settings]:
    """The default and the grid's frontier with all knobs that bettered the default.

    At most `ChartCase.products`, the ones with fewest changes first; those already measured left
    out, and meshes and steps that cost more than `ChartCase.reach` times the default.
    """
    knobs = useful(case, measured)
    found: dict[Settings, int] = {}
    for base in dict.fromkeys(
        [case.default, *_bases(case, _among(measured, grid(case)), measured)]
    ):
        for values in itertools.product(*knobs.values()):
            settings = replace(base, **dict(zip(knobs, values, strict=True)))
            changes = sum(
                value != getattr(case.default, knob)
                for knob, value in zip(knobs, values, strict=True)
            )
            if changes and case.has(settings):
                found.setdefault(settings, changes)
    wanted = sorted(found, key=lambda settings: found[settings])
    return _new(wanted, measured)[: case.products]


def neighbours(case: ChartCase, measured: Sequence[Measured], floor: float) -> list[Settings]:
    """One mesh and one time step up and down from the points of the frontier, at most as many."""
    meshes = list(dict.fromkeys([*usable_meshes(case), case.beside[0]]))
    steps = [step for step in TIME_STEPS if step >= min(case.time_steps)]
    wanted = []
    for base in _bases(case, measured, measured, floor):
        near = [(base.mesh, step) for step in _beside(steps, base.time_step)]
        near += [(mesh, base.time_step) for mesh in _beside(meshes, base.mesh)]
        wanted += [
            replace(base, cells=cells, level=level, time_step=step) for (cells, level), step in near
        ]
    return _new(list(dict.fromkeys(wanted)), measured)[: case.products]


def _beside(values: Sequence[T], value: T) -> list[T]:
    if value not in values:
        return []
    place = values.index(value)
    return [values[k] for k in (place - 1, place + 1) if 0 <= k < len(values)]


def _new(wanted: Sequence[Settings], measured: Sequence[Measured]) -> list[Settings]:
    known = {point.settings for point in measured}
    return [settings for settings in wanted if settings not in known]


def _bases(
    case: ChartCase, points: Sequence[Measured], measured: Sequence[Measured], floor: float = 0.0
) -> list[Settings]:
    """The frontier of some points as far as `ChartCase.reach` goes, without references."""
    (default,) = _among(measured, [case.default])
    references = set(reference_family(case))
    chosen = [point for point in points if point.settings not in references]
    return [
        point.settings
        for point in frontier(chosen, floor)
        if point.cost <= case.reach * default.cost
    ]


def useful(case: ChartCase, measured: Sequence[Measured]) -> dict[str, list[Any]]:
    """Knobs with the default's value and those that cost less, or err less, than the default.

    Of each knob the values that no other one of it beats, within the case's reach. Threads are left
    out: they cost no less and change no number.
    """
    (default,) = _among(measured, [case.default])
    kept: dict[str, list[Any]] = {}
    for knob, values in case.knobs.items():
        points = _among(measured, [replace(case.default, **{knob: value}) for value in values])
        better = [
            getattr(point.settings, knob)
            for point in frontier(points)
            if point.cost <= case.reach * default.cost
            if point.cost < (1.0 - WORTH) * default.cost
            or point.error < (1.0 - WORTH) * default.error
        ]
        if better and knob != "threads":
            kept[knob] = [getattr(case.default, knob), *better]
    return kept


def frontier(points: Iterable[Measured], floor: float = 0.0) -> list[Measured]:
    """Points than which none is both cheaper and better, by rising cost.

    One that betters the error of a cheaper one by less than WORTH is left out.
    Errors below ``floor``, which nobody can tell apart, count as equal to it.
    """
    kept: list[Measured] = []
    best = float("inf")
    for point in sorted(points, key=lambda point: (point.cost, point.error)):
        error = max(point.error, floor)
        if error < (1.0 - WORTH) * best:
            kept.append(point)
            best = error
    return kept


def _among(measured: Sequence[Measured], wanted: Sequence[Settings]) -> list[Measured]:
    chosen = set(wanted)
    return [point for point in measured if point.settings in chosen]


def first_points(case: ChartCase) -> list[Settings]:
    """All that does not depend on a measurement, the longest runs first."""
    plain = [case.default, case.usual, *grid(case), *singles(case)]
    return list(dict.fromkeys([*reference_family(case)[::-1], *plain]))
