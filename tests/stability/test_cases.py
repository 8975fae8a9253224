"""Every row of the stability table, run with the default options in both precisions."""

from __future__ import annotations

import itertools
from functools import cache

import pytest
from _pytest.mark import ParameterSet

from benchmarks.stability.cases import StabilityCase
from benchmarks.stability.outcomes import (
    CONFIGURATIONS,
    GAINS,
    StabilityOutcome,
    everything,
    examine,
)
from tests.stability.known import GAIN, HANGS_ON_ROUNDING, RECOVERY

ROWS = {row.name: row for row in everything()}
TESTED = [configuration for configuration in CONFIGURATIONS if configuration.startswith("default")]
"""The others are in the table only."""

SHORT_WORK = 2e5
"""Steps times tets up to which a case is run with every configuration by ``make test``."""


@cache
def outcome(name: str, configuration: str) -> StabilityOutcome:
    return examine(ROWS[name], configuration)


def takes_long(name: str, configuration: str) -> bool:
    """Long cases, and dear ones under all configurations but the first."""
    row = ROWS[name]
    if not isinstance(row, StabilityCase):
        return False
    setting = row.setting
    work = setting.steps * len(setting.starts) * len(setting.make().mesh.tets)
    return row.long or (configuration != TESTED[0] and work > SHORT_WORK)


def parameters(known: dict[tuple[str, str], str]) -> list[ParameterSet]:
    found = []
    for name, configuration in itertools.product(ROWS, TESTED):
        marks = [pytest.mark.long] if takes_long(name, configuration) else []
        if reason := known.get((name, configuration)):
            strict = known is GAIN or (name, configuration) not in HANGS_ON_ROUNDING
            marks.append(pytest.mark.xfail(strict=strict, reason=reason))
        found.append(pytest.param(name, configuration, marks=marks, id=f"{name}, {configuration}"))
    return found


@pytest.mark.parametrize(("name", "configuration"), parameters(RECOVERY))
def test_case_recovers(name: str, configuration: str) -> None:
    """The rest volume to 1 %, and the rest shape where it is damped; or it stops as it should."""
    failures = outcome(name, configuration).failures
    assert not {check: text for check, text in failures.items() if check not in GAINS}


@pytest.mark.parametrize(("name", "configuration"), parameters(GAIN))
def test_case_gains_nothing(name: str, configuration: str) -> None:
    """No energy and no spin but what the solver's residual and rounding explain."""
    failures = outcome(name, configuration).failures
    assert not {check: text for check, text in failures.items() if check in GAINS}


def test_known_failures_are_of_rows_that_there_are() -> None:
    pairs = {(name, configuration) for name in ROWS for configuration in TESTED}
    assert set(RECOVERY) <= pairs
    assert set(GAIN) <= pairs
    assert set(RECOVERY) >= HANGS_ON_ROUNDING
