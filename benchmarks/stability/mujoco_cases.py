"""MuJoCo in the place of ours: the same bodies and starts as a flex under its ``discrete`` step.

Its law is St. Venant-Kirchhoff's, so the energies of the suite are not its own and are not judged.
"""

from __future__ import annotations

import importlib
from dataclasses import replace
from typing import Any

import numpy as np

from benchmarks.stability.measures import Accuracy, StateProbe, StateSample
from benchmarks.stability.movers import CaseSetup, StepNote
from benchmarks.stability.starts import Begin
from warp_softbody import Character
from warp_softbody.arrays import FloatArray

TOLERANCE = 1e-5
ITERATIONS = 1000
UNKNOWN = float("inf")
"""What a step may add to an energy that is not known."""


def missing() -> str | None:
    """One sentence where MuJoCo cannot be run, None where it can."""
    try:
        module = importlib.import_module("mujoco")
    except ImportError:
        return "--peers needs the package mujoco; pip install 'warp-softbody[bench]'"
    if not hasattr(module.mjtIntegrator, "mjINT_DISCRETE"):
        return f"--peers needs MuJoCo 3.13 or later, not {module.__version__}"
    return None


def can_run(setting: CaseSetup) -> bool:
    """It has no muscles like ours; ground is left out, where contact would be compared."""
    return setting.pulled == 0 and setting.ground is None


class FlexBody:
    """A flex whose vertices are bodies with three slides each, without contact."""

    def __init__(self, setting: CaseSetup, begin: Begin) -> None:
        """Compile the model of a body and put it where it starts."""
        self.character = setting.make()
        self.probe = StateProbe(self.character, setting.gravity)
        self.accuracy = Accuracy(
            time_step=setting.time_step, tolerance=TOLERANCE, epsilon=float(np.finfo(float).eps)
        )
        self._mujoco = importlib.import_module("mujoco")
        # it writes warnings to a file in the working directory unless someone listens
        self._mujoco.set_mju_user_warning(lambda message: None)
        self._model = self._mujoco.MjModel.from_xml_string(_scene(self.character, setting))
        self._data = self._mujoco.MjData(self._model)
        self._free = np.setdiff1d(np.arange(len(self.probe.masses)), self.character.fixed)
        self._lump_masses()
        start = begin(self.character)
        moved = start.positions - self.character.mesh.points
        self._data.qpos[:] = moved[self._free].ravel()
        self._data.qvel[:] = start.velocities[self._free].ravel()

    def _lump_masses(self) -> None:
        """Give each vertex a quarter of its tets' mass; MuJoCo shares the mass out evenly."""
        model, masses = self._model, self.probe.masses[self._free]
        bodies = model.flex_vertbodyid[self._free]
        model.body_inertia[bodies] *= (masses / model.body_mass[bodies])[:, None]
        model.body_mass[bodies] = masses
        self._mujoco.mj_setConst(model, self._data)

    @property
    def positions(self) -> FloatArray:
        """(n, 3) m."""
        points = self.character.mesh.points.copy()
        points[self._free] += self._data.qpos.reshape(-1, 3)
        return np.asarray(points)

    @property
    def velocities(self) -> FloatArray:
        """(n, 3) m/s."""
        velocities = np.zeros_like(self.character.mesh.points)
        velocities[self._free] = self._data.qvel.reshape(-1, 3)
        return velocities

    def pull(self, share: float) -> None:
        """It has no muscles, and cases with them do not come here."""
        raise NotImplementedError("MuJoCo flex has no muscles")

    def step(self) -> StepNote:
        """One step; MuJoCo counts no iterations of this solve."""
        kinds, warnings = self._mujoco.mjtWarning, self._data.warning
        self._mujoco.mj_step(self._model, self._data)
        bad = (kinds.mjWARN_BADQPOS, kinds.mjWARN_BADQVEL, kinds.mjWARN_BADQACC)
        unsolved = warnings[int(kinds.mjWARN_INERTIA)].number
        warnings[int(kinds.mjWARN_INERTIA)].number = 0
        return StepNote(
            iterations=0,
            converged=unsolved == 0,
            finite=not any(warnings[int(kind)].number for kind in bad),
        )

    def sample(self) -> StateSample:
        """Measure the state; nothing is known of what a step may add to its energy."""
        sample = self.probe.sample(self.positions, self.velocities, self.accuracy)
        return replace(sample, energy_allowance=UNKNOWN, spin_allowance=UNKNOWN)


def _scene(character: Character, setting: CaseSetup) -> str:
    mesh, material = character.mesh, character.material
    points = " ".join(f"{value:.17g}" for value in mesh.points.ravel())
    tets = " ".join(map(str, mesh.tets.ravel()))
    held = " ".join(map(str, character.fixed))
    options: dict[str, Any] = {
        "timestep": setting.time_step,
        "integrator": "discrete",
        "solver": "CG",
        "tolerance": TOLERANCE,
        "iterations": ITERATIONS,
        "gravity": " ".join(map(str, setting.gravity)),
    }
    chosen = " ".join(f'{name}="{value}"' for name, value in options.items())
    return f"""
    <mujoco>
      <option {chosen}><flag autoreset="disable"/></option>
      <size memory="2G"/>
      <worldbody>
        <flexcomp name="body" type="direct" dim="3" mass="{material.density * mesh.volume}"
                  radius="0.0001" point="{points}" element="{tets}">
          {f'<pin id="{held}"/>' if held else ""}
          <contact contype="0" conaffinity="0" selfcollide="none"/>
          <elasticity young="{material.young_modulus}" poisson="{material.poisson_ratio}"
                      damping="{material.stiffness_damping}"/>
        </flexcomp>
      </worldbody>
    </mujoco>"""
