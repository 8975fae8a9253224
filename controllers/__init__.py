"""Controllers: objectives, the contact QPCC of one step and its solvers."""

from warp_softbody.controllers.balance import Balance, BalanceGains
from warp_softbody.controllers.controller import ActivationCost, Controller, Goals
from warp_softbody.controllers.full_form import FullForm, to_full
from warp_softbody.controllers.objectives import Objective
from warp_softbody.controllers.patches import Patch, ground_patches
from warp_softbody.controllers.qpcc import ContactQPCC, uniform_directions
from warp_softbody.controllers.result import QPCCResult, QPCCStatus, SolverOptions
from warp_softbody.controllers.solver import enumerate_qpcc, solve_qpcc, solve_static

__all__ = [
    "ActivationCost",
    "Balance",
    "BalanceGains",
    "ContactQPCC",
    "Controller",
    "FullForm",
    "Goals",
    "Objective",
    "Patch",
    "QPCCResult",
    "QPCCStatus",
    "SolverOptions",
    "enumerate_qpcc",
    "ground_patches",
    "solve_qpcc",
    "solve_static",
    "to_full",
    "uniform_directions",
]
