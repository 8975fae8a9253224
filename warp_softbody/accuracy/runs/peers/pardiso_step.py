"""The same corotational step with a direct solve: NumPy assembly, MKL Pardiso on one thread.

The matrix is declared symmetric and positive definite, its upper triangle handed over, and the
symbolic analysis is done once, since the pattern never changes: each step factorises and solves.
"""

from __future__ import annotations

import importlib
import time
from typing import Any

import numpy as np

from warp_softbody.accuracy.runs.peers.beam import Cantilever, StepReport
from warp_softbody.accuracy.runs.peers.corotation import CorotationalSystem
from warp_softbody.arrays import FloatArray

SYMMETRIC_POSITIVE_DEFINITE = 2
ANALYSE = 11
FACTORISE_AND_SOLVE = 23


class PardisoBeam:
    """Positions and velocities in NumPy, and Pardiso's factor."""

    def __init__(self, beam: Cantilever, time_step: float) -> None:
        """Analyse the pattern of a beam at rest."""
        self._system = CorotationalSystem(beam, time_step, upper=True)
        self._time_step = time_step
        self._positions: FloatArray = beam.mesh.points.copy()
        self._velocities: FloatArray = np.zeros_like(self._positions)
        self._assembly_ms = 0.0
        module = importlib.import_module("pypardiso")
        self._pardiso = module.PyPardisoSolver(mtype=SYMMETRIC_POSITIVE_DEFINITE)
        self._pardiso.libmkl.MKL_Set_Num_Threads(1)
        matrix, b = self._system.assemble(self._positions, self._velocities)
        self._call(ANALYSE, matrix, b.ravel()[self._system.free])

    def _call(self, phase: int, matrix: Any, right: FloatArray) -> FloatArray:
        # pypardiso's own solve() would repeat the analysis in every step
        self._pardiso.set_phase(phase)
        return np.asarray(self._pardiso._call_pardiso(matrix, right))

    def step(self) -> StepReport:
        """One step."""
        free = self._system.free
        begun = time.perf_counter()
        matrix, b = self._system.assemble(self._positions, self._velocities)
        right = b.ravel()[free]
        assembled = time.perf_counter()
        solution = self._call(FACTORISE_AND_SOLVE, matrix, right)
        solved = time.perf_counter()
        self._velocities.ravel()[free] = solution
        self._positions += self._time_step * self._velocities
        self._assembly_ms = 1e3 * (assembled - begun)
        return StepReport(solve_ms=1e3 * (solved - assembled))

    def assembly_ms(self) -> float:
        """That of the last step, ms."""
        return self._assembly_ms

    def positions(self) -> FloatArray:
        """(n, 3) m, a copy."""
        return np.array(self._positions)

    def state(self) -> tuple[FloatArray, FloatArray]:
        """Copies of positions, m, and velocities, m/s."""
        return self.positions(), np.array(self._velocities)
