"""The cantilever as a MuJoCo flex under its ``discrete`` integrator.

The law is St. Venant-Kirchhoff, so its system is not the corotational one and its residual cannot
be computed from outside. MuJoCo solves ``(M + dt^2 K) a = f - dt K v`` by conjugate gradients with
3 x 3 blocks as preconditioner until the residual is ``tolerance`` of the right-hand side's, and
warns with the residual that it reached when ``iterations`` did not suffice.
"""

from __future__ import annotations

import importlib
import re

import numpy as np

from warp_softbody.accuracy.runs.peers.beam import GRAVITY, MATERIAL, Cantilever, StepReport
from warp_softbody.arrays import FloatArray
from warp_softbody.body.mesh_geometry import lumped_masses

REACHED = re.compile(r"relative residual of ([0-9.]+(?:e[+-]?[0-9]+)?)")
HEIGHT = 2.0
"""Where the beam is placed, m; nothing else is in the scene."""


class MujocoBeam:
    """A flex whose vertices are bodies with three slides each, contact switched off."""

    def __init__(
        self, beam: Cantilever, time_step: float, tolerance: float, iterations: int
    ) -> None:
        """Compile the model of a beam at rest."""
        self._mujoco = importlib.import_module("mujoco")
        self._messages: list[str] = []
        # MuJoCo writes warnings to a file in the working directory unless someone listens
        self._mujoco.set_mju_user_warning(self._messages.append)
        text = _scene(beam, time_step, tolerance, iterations)
        self._model = self._mujoco.MjModel.from_xml_string(text)
        self._data = self._mujoco.MjData(self._model)
        self._lump_masses(beam)
        self._inertia = int(self._mujoco.mjtWarning.mjWARN_INERTIA)

    def _lump_masses(self, beam: Cantilever) -> None:
        """Give each vertex a quarter of its tets' mass; MuJoCo shares the mass out evenly."""
        mesh, model = beam.mesh, self._model
        masses = lumped_masses(mesh.tets, mesh.volumes, len(mesh.points), MATERIAL.density)
        masses = masses[~beam.fixed]
        bodies = model.flex_vertbodyid[~beam.fixed]
        model.body_inertia[bodies] *= (masses / model.body_mass[bodies])[:, None]
        model.body_mass[bodies] = masses
        self._mujoco.mj_setConst(model, self._data)

    def step(self) -> StepReport:
        """One step; MuJoCo does not count the iterations of this solve."""
        self._messages.clear()
        self._mujoco.set_mju_user_warning(self._messages.append)
        # only a run's first warning has the residual in it
        self._data.warning[self._inertia].number = 0
        self._mujoco.mj_step(self._model, self._data)
        reached = [float(m.group(1)) for text in self._messages if (m := REACHED.search(text))]
        return StepReport(
            converged=self._data.warning[self._inertia].number == 0,
            residual=max(reached, default=None),
        )

    def assembly_ms(self) -> None:
        """Not to be had apart."""
        return None

    def positions(self) -> FloatArray:
        """(n, 3) m, a copy."""
        self._mujoco.mj_kinematics(self._model, self._data)
        self._mujoco.mj_flex(self._model, self._data)
        return np.asarray(self._data.flexvert_xpos - np.array([0.0, 0.0, HEIGHT]))

    def state(self) -> None:
        """None: its steps solve a system of their own."""
        return None


def _scene(beam: Cantilever, time_step: float, tolerance: float, iterations: int) -> str:
    points = " ".join(f"{value:.17g}" for value in beam.mesh.points.ravel())
    tets = " ".join(map(str, beam.mesh.tets.ravel()))
    pins = " ".join(map(str, np.flatnonzero(beam.fixed)))
    mass = MATERIAL.density * float(beam.mesh.volumes.sum())
    return f"""
    <mujoco>
      <option timestep="{time_step}" integrator="discrete" solver="CG" tolerance="{tolerance}"
              iterations="{iterations}" gravity="0 0 {-GRAVITY}"/>
      <size memory="2G"/>
      <worldbody>
        <flexcomp name="beam" type="direct" dim="3" pos="0 0 {HEIGHT}" mass="{mass}"
                  radius="0.0001" point="{points}" element="{tets}">
          <pin id="{pins}"/>
          <contact contype="0" conaffinity="0" selfcollide="none"/>
          <elasticity young="{MATERIAL.young_modulus}" poisson="{MATERIAL.poisson_ratio}"
                      damping="0"/>
        </flexcomp>
      </worldbody>
    </mujoco>"""
