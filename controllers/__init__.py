"""Controllers: objectives, the motions, and the solver of the control problem of one step.

Names are resolved on first use, so that the QPCC solver is loaded without motions and engine.
"""

from __future__ import annotations

from importlib import import_module
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from warp_softbody.controllers.body_units import BodyUnits
    from warp_softbody.controllers.control_options import ControlOptions
    from warp_softbody.controllers.controller import ActivationCost, Controller, Goals
    from warp_softbody.controllers.motions.balance import Balance, BalanceGains
    from warp_softbody.controllers.motions.cartwheel import Cartwheel
    from warp_softbody.controllers.motions.cartwheel_gains import CartwheelGains
    from warp_softbody.controllers.motions.combined import Combined
    from warp_softbody.controllers.motions.crawl import Crawl, CrawlGains, CrawlPhase
    from warp_softbody.controllers.motions.exercise import Exercise, ExerciseGains, Sway
    from warp_softbody.controllers.motions.flip import Flip
    from warp_softbody.controllers.motions.flip_gains import FlipGains, TakeOff
    from warp_softbody.controllers.motions.for_any_body.step_gains import StepGains
    from warp_softbody.controllers.motions.gesture import Gesture, GestureGains
    from warp_softbody.controllers.motions.jump import Jump
    from warp_softbody.controllers.motions.jump_gains import JumpGains
    from warp_softbody.controllers.motions.leap import Leap
    from warp_softbody.controllers.motions.leap_gains import LeapGains
    from warp_softbody.controllers.motions.motion import Motion
    from warp_softbody.controllers.motions.recovery_gains import RecoveryGains
    from warp_softbody.controllers.motions.roll import Roll
    from warp_softbody.controllers.motions.roll_gains import Leg, RollGains
    from warp_softbody.controllers.motions.sequence import Sequence
    from warp_softbody.controllers.motions.slide import Slide, SlideGains
    from warp_softbody.controllers.motions.steering import Steering, Trail
    from warp_softbody.controllers.motions.walk import DIAGONAL_PAIRS, ONE_BY_ONE, Walk
    from warp_softbody.controllers.motions.walk_gains import WalkGains
    from warp_softbody.controllers.objectives import Objective
    from warp_softbody.controllers.patch_clusters import clustered_patches
    from warp_softbody.controllers.patches import Patch, ground_patches
    from warp_softbody.controllers.qpcc import (
        COLD_OPTIONS,
        QPCC,
        WARM_OPTIONS,
        ContactMultipliers,
        ContactQPCC,
        FullForm,
        GeneralMultipliers,
        GeneralResult,
        QPCCResult,
        QPCCStatus,
        SolverOptions,
        enumerate_qpcc,
        solve_qpcc,
        solve_static,
        to_full,
        to_general,
        uniform_directions,
    )

_HOMES = {
    "ActivationCost": "controller",
    "Balance": "motions.balance",
    "BalanceGains": "motions.balance",
    "BodyUnits": "body_units",
    "COLD_OPTIONS": "qpcc",
    "Cartwheel": "motions.cartwheel",
    "CartwheelGains": "motions.cartwheel_gains",
    "Combined": "motions.combined",
    "ContactMultipliers": "qpcc",
    "ContactQPCC": "qpcc",
    "ControlOptions": "control_options",
    "Controller": "controller",
    "Crawl": "motions.crawl",
    "CrawlGains": "motions.crawl",
    "CrawlPhase": "motions.crawl",
    "DIAGONAL_PAIRS": "motions.walk",
    "Exercise": "motions.exercise",
    "ExerciseGains": "motions.exercise",
    "Flip": "motions.flip",
    "FlipGains": "motions.flip_gains",
    "FullForm": "qpcc",
    "GeneralMultipliers": "qpcc",
    "GeneralResult": "qpcc",
    "Gesture": "motions.gesture",
    "GestureGains": "motions.gesture",
    "Goals": "controller",
    "Jump": "motions.jump",
    "JumpGains": "motions.jump_gains",
    "Leap": "motions.leap",
    "LeapGains": "motions.leap_gains",
    "Leg": "motions.roll_gains",
    "Motion": "motions.motion",
    "ONE_BY_ONE": "motions.walk",
    "Objective": "objectives",
    "Patch": "patches",
    "QPCC": "qpcc",
    "QPCCResult": "qpcc",
    "QPCCStatus": "qpcc",
    "RecoveryGains": "motions.recovery_gains",
    "Roll": "motions.roll",
    "RollGains": "motions.roll_gains",
    "Sequence": "motions.sequence",
    "Slide": "motions.slide",
    "SlideGains": "motions.slide",
    "SolverOptions": "qpcc",
    "StepGains": "motions.for_any_body.step_gains",
    "Steering": "motions.steering",
    "Sway": "motions.exercise",
    "TakeOff": "motions.flip_gains",
    "Trail": "motions.steering",
    "WARM_OPTIONS": "qpcc",
    "Walk": "motions.walk",
    "WalkGains": "motions.walk_gains",
    "clustered_patches": "patch_clusters",
    "enumerate_qpcc": "qpcc",
    "ground_patches": "patches",
    "solve_qpcc": "qpcc",
    "solve_static": "qpcc",
    "to_full": "qpcc",
    "to_general": "qpcc",
    "uniform_directions": "qpcc",
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
    "BodyUnits",
    "Cartwheel",
    "CartwheelGains",
    "Combined",
    "ContactMultipliers",
    "ContactQPCC",
    "ControlOptions",
    "Controller",
    "Crawl",
    "CrawlGains",
    "CrawlPhase",
    "Exercise",
    "ExerciseGains",
    "Flip",
    "FlipGains",
    "FullForm",
    "GeneralMultipliers",
    "GeneralResult",
    "Gesture",
    "GestureGains",
    "Goals",
    "Jump",
    "JumpGains",
    "Leap",
    "LeapGains",
    "Leg",
    "Motion",
    "Objective",
    "Patch",
    "QPCCResult",
    "QPCCStatus",
    "RecoveryGains",
    "Roll",
    "RollGains",
    "Sequence",
    "Slide",
    "SlideGains",
    "SolverOptions",
    "Steering",
    "StepGains",
    "Sway",
    "TakeOff",
    "Trail",
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
