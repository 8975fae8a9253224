"""Quadratic programs with complementarity constraints (QPCCs) and their solver.

A library of its own: it needs NumPy, SciPy, PIQP and DAQP, and of the package only the checks of
input. docs/qpcc.md says what it solves and how, with examples. Names are resolved on first use.
"""

from __future__ import annotations

from importlib import import_module
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from warp_softbody.contact_mode import ContactMode
    from warp_softbody.controllers.qpcc.contact.complementarity_form import (
        FullForm,
        to_full,
        to_general,
    )
    from warp_softbody.controllers.qpcc.contact.problem import ContactQPCC, uniform_directions
    from warp_softbody.controllers.qpcc.general.b_stationarity import (
        BStationarity,
        b_stationarity,
    )
    from warp_softbody.controllers.qpcc.general.casadi_reader import from_casadi
    from warp_softbody.controllers.qpcc.general.problem import QPCC
    from warp_softbody.controllers.qpcc.result import (
        COLD_OPTIONS,
        WARM_OPTIONS,
        ContactMultipliers,
        GeneralMultipliers,
        GeneralResult,
        QPCCResult,
        QPCCStatus,
        SolverOptions,
    )
    from warp_softbody.controllers.qpcc.solve import enumerate_qpcc, solve_qpcc, solve_static

_HOMES = {
    "BStationarity": f"{__name__}.general.b_stationarity",
    "b_stationarity": f"{__name__}.general.b_stationarity",
    "from_casadi": f"{__name__}.general.casadi_reader",
    "COLD_OPTIONS": f"{__name__}.result",
    "ContactMode": "warp_softbody.contact_mode",
    "ContactMultipliers": f"{__name__}.result",
    "ContactQPCC": f"{__name__}.contact.problem",
    "FullForm": f"{__name__}.contact.complementarity_form",
    "GeneralMultipliers": f"{__name__}.result",
    "GeneralResult": f"{__name__}.result",
    "QPCC": f"{__name__}.general.problem",
    "QPCCResult": f"{__name__}.result",
    "QPCCStatus": f"{__name__}.result",
    "SolverOptions": f"{__name__}.result",
    "WARM_OPTIONS": f"{__name__}.result",
    "enumerate_qpcc": f"{__name__}.solve",
    "solve_qpcc": f"{__name__}.solve",
    "solve_static": f"{__name__}.solve",
    "to_full": f"{__name__}.contact.complementarity_form",
    "to_general": f"{__name__}.contact.complementarity_form",
    "uniform_directions": f"{__name__}.contact.problem",
}

__all__ = [
    "COLD_OPTIONS",
    "QPCC",
    "WARM_OPTIONS",
    "BStationarity",
    "ContactMode",
    "ContactMultipliers",
    "ContactQPCC",
    "FullForm",
    "GeneralMultipliers",
    "GeneralResult",
    "QPCCResult",
    "QPCCStatus",
    "SolverOptions",
    "b_stationarity",
    "enumerate_qpcc",
    "from_casadi",
    "solve_qpcc",
    "solve_static",
    "to_full",
    "to_general",
    "uniform_directions",
]


def __getattr__(name: str) -> Any:
    """Import the home of a public name (PEP 562)."""
    if name not in _HOMES:
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
    return getattr(import_module(_HOMES[name]), name)


def __dir__() -> list[str]:
    """Public names, for completion."""
    return sorted(__all__)
