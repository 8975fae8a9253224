"""What a case comes to under a configuration, in words and numbers."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator
from dataclasses import asdict, dataclass
from typing import Any

from benchmarks.stability.cases import StabilityCase
from benchmarks.stability.catalogue import CASES
from benchmarks.stability.movers import OurBody
from benchmarks.stability.mujoco_cases import FlexBody, can_run
from benchmarks.stability.peers import MUJOCO
from benchmarks.stability.runs import Run, run
from benchmarks.stability.stops import STOPS, Stop

SINGLE: dict[str, Any] = {"precision": "float32"}

CONFIGURATIONS: dict[str, dict[str, Any]] = {
    "default float32": SINGLE,
    "default float64": {"precision": "float64"},
    "conserving float32": {**SINGLE, "tangent": "conserving"},
    "exact float32": {**SINGLE, "tangent": "exact"},
    "smoothed float32": {**SINGLE, "elements": "smoothed"},
}
"""Options by the name of their column."""

GAINS = ("energy", "spin")
"""Checks that a body gains nothing."""


@dataclass(frozen=True, kw_only=True)
class StabilityOutcome:
    """One case under one configuration.

    Attributes:
        case: its name.
        configuration: name of the options.
        verdict: in a few words.
        failures: by check, what the worst run failed it with; empty where all is well.
        runs: one for each start; none for a case that has to stop.
    """

    case: str
    configuration: str
    verdict: str
    failures: dict[str, str]
    runs: tuple[Run, ...] = ()

    def to_dict(self) -> dict[str, Any]:
        """Plain values, ready for JSON; null for what a run did not come to."""
        values = asdict(self)
        for one in values["runs"]:
            one.update({key: None for key, value in one.items() if _is_no_number(value)})
        return values


def _is_no_number(value: object) -> bool:
    return isinstance(value, float) and not math.isfinite(value)


def examine(case: StabilityCase | Stop, configuration: str) -> StabilityOutcome:
    """Run a case."""
    if isinstance(case, Stop):
        ending = case.attempt(CONFIGURATIONS[configuration])
        return StabilityOutcome(
            case=case.name,
            configuration=configuration,
            verdict=ending.said,
            failures={} if ending.failed is None else {"stops": ending.failed},
        )
    setting, options = case.setting, CONFIGURATIONS[configuration]
    runs = tuple(run(setting, OurBody(setting, begin, options)) for begin in setting.starts)
    # the suite's energy is that of plain tets
    plain = options.get("elements", "linear") == "linear"
    return _judged(case, configuration, runs, gains=plain)


def examine_mujoco(case: StabilityCase) -> StabilityOutcome:
    """Run a case with MuJoCo, whose energy and spin are not judged."""
    runs = tuple(run(case.setting, FlexBody(case.setting, begin)) for begin in case.setting.starts)
    return _judged(case, MUJOCO, runs, gains=False)


def _judged(
    case: StabilityCase, configuration: str, runs: tuple[Run, ...], *, gains: bool
) -> StabilityOutcome:
    """What failed by check, each text once, the run farthest from rest first, and a verdict."""
    order = sorted(runs, key=lambda one: -abs(one.volume - 1.0))
    failed = [case.failures(one) for one in order]
    checks = {check for one in failed for check in one if gains or check not in GAINS}
    failures = {
        check: list(dict.fromkeys(one[check] for one in failed if check in one))
        for check in sorted(checks, key=lambda check: (check in GAINS, check))
    }
    lost = [one for one in failed if any(check not in GAINS for check in one)]
    verdict = case.goal.value
    if lost:
        verdict = ", ".join(text for check, text in lost[0].items() if check not in GAINS)
        if len(runs) > 1:
            good = len(runs) - len(lost)
            verdict = f"{case.goal.value} from {good} of {len(runs)}, else {verdict}"
    gained = [texts[0] for check, texts in failures.items() if check in GAINS]
    if gained:
        verdict = f"{verdict}, but {' and '.join(gained)}"
    return StabilityOutcome(
        case=case.name,
        configuration=configuration,
        verdict=verdict,
        failures={check: "; ".join(texts) for check, texts in failures.items()},
        runs=runs,
    )


def everything() -> tuple[StabilityCase | Stop, ...]:
    """All rows."""
    return (*CASES, *STOPS)


def examine_all(
    names: list[str] | None, progress: Callable[[str], None], *, peers: bool
) -> Iterator[StabilityOutcome]:
    """Outcomes of some rows or all, row by row; with ``peers``, MuJoCo's too."""
    for case in everything():
        if names is not None and case.name not in names:
            continue
        for configuration in CONFIGURATIONS:
            progress(f"{case.name}, {configuration}")
            yield examine(case, configuration)
        if peers and isinstance(case, StabilityCase) and can_run(case.setting):
            progress(f"{case.name}, {MUJOCO}")
            yield examine_mujoco(case)
