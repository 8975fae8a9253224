"""Controllers: objectives, the contact QPCC of one step and its solvers."""

from warp_softbody.controllers.full_form import FullForm, to_full
from warp_softbody.controllers.qpcc import ContactQPCC, uniform_directions
from warp_softbody.controllers.result import QPCCResult, QPCCStatus, SolverOptions
from warp_softbody.controllers.solver import enumerate_qpcc, solve_qpcc, solve_static

__all__ = [
    "ContactQPCC",
    "FullForm",
    "QPCCResult",
    "QPCCStatus",
    "SolverOptions",
    "enumerate_qpcc",
    "solve_qpcc",
    "solve_static",
    "to_full",
    "uniform_directions",
]
