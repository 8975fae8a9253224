"""Controllers: objectives, the contact QPCC of one step and its solvers.

Names are resolved on first use, so that the QPCC can be used without the motions and the engine.
"""

from __future__ import annotations

from importlib import import_module
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from warp_softbody.controllers.controller import ActivationCost, Controller, Goals
    from warp_softbody.controllers.motions.balance import Balance, BalanceGains
    from warp_softbody.controllers.motions.crawl import Crawl, CrawlGains, CrawlPhase
    from warp_softbody.controllers.motions.exercise import Exercise, ExerciseGains, Sway
    from warp_softbody.controllers.motions.jump import Jump, JumpGains
    from warp_softbody.controllers.motions.roll import Leg, Roll, RollGains
    from warp_softbody.controllers.motions.slide import Slide, SlideGains
    from warp_softbody.controllers.motions.walk import DIAGONAL_PAIRS, ONE_BY_ONE, Walk, WalkGains
    from warp_softbody.controllers.objectives import Objective
    from warp_softbody.controllers.patch_clusters import clustered_patches
    from warp_softbody.controllers.patches import Patch, ground_patches
    from warp_softbody.controllers.qpcc.contact.complementarity_form import (
        FullForm,
        to_full,
        to_general,
    )
    from warp_softbody.controllers.qpcc.contact.problem import ContactQPCC, uniform_directions
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
    "ActivationCost": "controller",
    "Balance": "motions.balance",
    "BalanceGains": "motions.balance",
    "COLD_OPTIONS": "qpcc.result",
    "ContactMultipliers": "qpcc.result",
    "ContactQPCC": "qpcc.contact.problem",
    "Controller": "controller",
    "Crawl": "motions.crawl",
    "CrawlGains": "motions.crawl",
    "CrawlPhase": "motions.crawl",
    "DIAGONAL_PAIRS": "motions.walk",
    "Exercise": "motions.exercise",
    "ExerciseGains": "motions.exercise",
    "FullForm": "qpcc.contact.complementarity_form",
    "GeneralMultipliers": "qpcc.result",
    "GeneralResult": "qpcc.result",
    "Goals": "controller",
    "Jump": "motions.jump",
    "JumpGains": "motions.jump",
    "Leg": "motions.roll",
    "ONE_BY_ONE": "motions.walk",
    "Objective": "objectives",
    "Patch": "patches",
    "QPCC": "qpcc.general.problem",
    "QPCCResult": "qpcc.result",
    "QPCCStatus": "qpcc.result",
    "Roll": "motions.roll",
    "RollGains": "motions.roll",
    "Slide": "motions.slide",
    "SlideGains": "motions.slide",
    "SolverOptions": "qpcc.result",
    "Sway": "motions.exercise",
    "WARM_OPTIONS": "qpcc.result",
    "Walk": "motions.walk",
    "WalkGains": "motions.walk",
    "clustered_patches": "patch_clusters",
    "enumerate_qpcc": "qpcc.solve",
    "ground_patches": "patches",
    "solve_qpcc": "qpcc.solve",
    "solve_static": "qpcc.solve",
    "to_full": "qpcc.contact.complementarity_form",
    "to_general": "qpcc.contact.complementarity_form",
    "uniform_directions": "qpcc.contact.problem",
}

__all__ = [
    "COLD_OPTIONS",
    "DIAGONAL_PAIRS",
    "ONE_BY_ONE",
    "QPCC",
    "WARM_OPTIONS",
    "ActivationCost",
    "Balance",
    "BalanceGains",
    "ContactMultipliers",
    "ContactQPCC",
    "Controller",
    "Crawl",
    "CrawlGains",
    "CrawlPhase",
    "Exercise",
    "ExerciseGains",
    "FullForm",
    "GeneralMultipliers",
    "GeneralResult",
    "Goals",
    "Jump",
    "JumpGains",
    "Leg",
    "Objective",
    "Patch",
    "QPCCResult",
    "QPCCStatus",
    "Roll",
    "RollGains",
    "Slide",
    "SlideGains",
    "SolverOptions",
    "Sway",
    "Walk",
    "WalkGains",
    "clustered_patches",
    "enumerate_qpcc",
    "ground_patches",
    "solve_qpcc",
    "solve_static",
    "to_full",
    "to_general",
    "uniform_directions",
]


def __getattr__(name: str) -> Any:
    """Import the home of a public name."""
    if name not in _HOMES:
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
    return getattr(import_module(f"{__name__}.{_HOMES[name]}"), name)


def __dir__() -> list[str]:
    """Public names, for completion."""
    return sorted(__all__)
