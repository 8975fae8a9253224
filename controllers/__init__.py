"""Controllers: objectives, the contact QPCC of one step and its solvers."""

from warp_softbody.controllers.balance import Balance, BalanceGains
from warp_softbody.controllers.controller import ActivationCost, Controller, Goals
from warp_softbody.controllers.crawl import Crawl, CrawlGains, CrawlPhase
from warp_softbody.controllers.exercise import Exercise, ExerciseGains, Sway
from warp_softbody.controllers.full_form import FullForm, to_full, to_general
from warp_softbody.controllers.general import QPCC
from warp_softbody.controllers.jump import Jump, JumpGains
from warp_softbody.controllers.objectives import Objective
from warp_softbody.controllers.patch_clusters import clustered_patches
from warp_softbody.controllers.patches import Patch, ground_patches
from warp_softbody.controllers.qpcc import ContactQPCC, uniform_directions
from warp_softbody.controllers.result import (
    COLD_OPTIONS,
    WARM_OPTIONS,
    ContactMultipliers,
    GeneralMultipliers,
    GeneralResult,
    QPCCResult,
    QPCCStatus,
    SolverOptions,
)
from warp_softbody.controllers.roll import Leg, Roll, RollGains
from warp_softbody.controllers.slide import Slide, SlideGains
from warp_softbody.controllers.solver import enumerate_qpcc, solve_qpcc, solve_static
from warp_softbody.controllers.walk import DIAGONAL_PAIRS, ONE_BY_ONE, Walk, WalkGains

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
