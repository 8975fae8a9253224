"""Stored QPCC instances: known best values against ours from a cold start."""

from __future__ import annotations

import glob
import os
import time
from dataclasses import dataclass
from typing import Any

import numpy as np

from warp_softbody.arrays import FloatArray
from warp_softbody.controllers import QPCC, ContactQPCC, solve_qpcc, solve_static
from warp_softbody.controllers.qpcc.contact.complementarity_form import force_map

RELATIVE, ABSOLUTE = 1e-3, 1e-6
"""A value counts as reached within the larger of the two."""


@dataclass(frozen=True, kw_only=True)
class Row:
    """One instance.

    Attributes:
        name: of the file.
        value: ours.
        best: known.
        residual: complementarity, not scaled.
        qps: used.
        seconds: CPU.
        status: of the result.
        gap: share of the gain of the best over the static baseline, contact instances only.
    """

    name: str
    value: float
    best: float
    residual: float
    qps: int
    seconds: float
    status: str
    gap: float | None = None

    @property
    def relative(self) -> float:
        """How much worse than the best known value; nan where no point was found."""
        return (self.value - self.best) / max(abs(self.best), ABSOLUTE / RELATIVE)

    @property
    def reached(self) -> bool:
        """Within the tolerance, or better."""
        return self.relative <= RELATIVE


def paths(folder: str, pattern: str = "*") -> list[str]:
    """Instance files by name."""
    return sorted(glob.glob(os.path.join(folder, f"{pattern}.npz")))


def general_row(path: str) -> Row:
    """One instance in general form, with the default budget."""
    problem = QPCC.load(path)
    best = float(np.load(path)["f_best"])
    began = time.process_time()
    result = solve_qpcc(problem)
    seconds = time.process_time() - began
    left, right = problem.sides(result.x)
    usable = result.status.name not in ("NO_POINT", "INFEASIBLE", "UNBOUNDED")
    return Row(
        name=os.path.basename(path)[:-4],
        value=result.objective if usable else np.nan,
        best=best,
        residual=float(np.abs(np.minimum(left, right)).max(initial=0.0)),
        qps=result.qp_count,
        seconds=seconds,
        status=result.status.name,
    )


def contact_row(path: str) -> Row:
    """One three-dimensional contact instance in contact form."""
    with np.load(path) as file:
        data = {name: file[name] for name in file.files}
    problem, best = read_contact(data), float(data["f_best"])
    began = time.process_time()
    result = solve_qpcc(problem)
    seconds = time.process_time() - began
    gain = solve_static(problem).objective - best
    return Row(
        name=os.path.basename(path)[:-4],
        value=result.objective,
        best=best,
        residual=result.complementarity,
        qps=result.qp_count,
        seconds=seconds,
        status=result.status.name,
        gap=(result.objective - best) / gain,
    )


def read_contact(data: dict[str, FloatArray]) -> ContactQPCC:
    """A stored contact instance in contact form (its directions may come in any order)."""
    k, m, nu = int(data["nc"]), int(data["m_dirs"]), int(data["nu"])
    physics: dict[str, Any] = {
        "lower": data["lb"][:nu],
        "upper": data["ub"][:nu],
        "velocity_offset": data["v0"],
        "velocity_from_controls": data["B"],
        "velocity_from_forces": data["W"],
    }
    rows = data["R"][1 : m + 1, :nu]
    directions = np.linalg.lstsq(data["B"][1:3].T, rows.T, rcond=None)[0].T
    order = np.argsort(np.round(np.arctan2(directions[:, 1], directions[:, 0]), 9) % (2 * np.pi))
    directions = directions[order] / np.linalg.norm(directions[order], axis=1)[:, None]
    law: dict[str, Any] = {"friction": np.full(k, float(data["mu"])), "directions": directions}
    size = nu + 3 * k
    bare = ContactQPCC(hessian=np.zeros((size, size)), gradient=np.zeros(size), **physics, **law)
    within = [nu + (m + 2) * i + np.r_[0, 1 + order, m + 1] for i in range(k)]
    column = np.concatenate([np.arange(nu), *within])
    back = np.linalg.pinv(force_map(bare))
    return ContactQPCC(
        hessian=back.T @ data["Q"][np.ix_(column, column)] @ back,
        gradient=back.T @ data["c"][column],
        constant=float(data["c0"]),
        **physics,
        **law,
    )
