"""A passive scene of one body over a level floor, as a MuJoCo flex under its ``discrete`` step.

Its law is St. Venant-Kirchhoff's, its friction cone is elliptic. Its contacts are soft constraints,
as stiff as MuJoCo lets them be: with a time constant of two steps, so that they harden as dt falls.
"""

from __future__ import annotations

import importlib
from dataclasses import dataclass
from typing import Any

import numpy as np

from warp_softbody.arrays import FloatArray
from warp_softbody.body.mesh_geometry import lumped_masses
from warp_softbody.world.ground import Plane
from warp_softbody.world.scene import Scene

TOLERANCE = 1e-5
"""Of the linear solve, as of ours in single precision."""
ITERATIONS = 1000
RADIUS = 1e-4
"""Of a vertex, m: its contacts begin so far above the floor."""


@dataclass(frozen=True, kw_only=True)
class FlexStep:
    """What a step says about itself.

    Attributes:
        converged: whether MuJoCo did not warn.
    """

    converged: bool


class FlexOnFloor:
    """The scene's body at rest, moving as it does at the start."""

    def __init__(self, scene: Scene, time_step: float) -> None:
        """Compile the model."""
        self._mujoco = importlib.import_module("mujoco")
        # it writes warnings to a file in the working directory unless someone listens
        self._mujoco.set_mju_user_warning(lambda message: None)
        self._model = self._mujoco.MjModel.from_xml_string(_text(scene, time_step))
        self._data = self._mujoco.MjData(self._model)
        self._rest = scene.character.mesh.points
        self._lump_masses(scene)
        self._data.qvel[:] = np.tile(scene.initial_velocity, len(self._rest))
        self._inertia = int(self._mujoco.mjtWarning.mjWARN_INERTIA)

    def _lump_masses(self, scene: Scene) -> None:
        """Give each vertex a quarter of its tets' mass; MuJoCo shares the mass out evenly."""
        model, body = self._model, scene.character
        mesh, density = body.mesh, body.material.density
        masses = lumped_masses(mesh.tets, mesh.volumes, len(mesh.points), density)
        bodies = model.flex_vertbodyid
        model.body_inertia[bodies] *= (masses / model.body_mass[bodies])[:, None]
        model.body_mass[bodies] = masses
        self._mujoco.mj_setConst(model, self._data)

    def step(self) -> FlexStep:
        """Advance."""
        self._mujoco.set_mju_user_warning(lambda message: None)
        self._data.warning[self._inertia].number = 0
        self._mujoco.mj_step(self._model, self._data)
        return FlexStep(converged=self._data.warning[self._inertia].number == 0)

    def positions(self) -> FloatArray:
        """(n, 3) m."""
        return np.asarray(self._rest + self._data.qpos.reshape(-1, 3))


def _text(scene: Scene, time_step: float) -> str:
    mesh, material = scene.character.mesh, scene.character.material
    assert isinstance(scene.ground, Plane)
    friction = f"{scene.ground.friction} 0 0"
    solref = f"{2.0 * time_step} 1"
    options: dict[str, Any] = {
        "timestep": time_step,
        "integrator": "discrete",
        "solver": "CG",
        "cone": "elliptic",
        "tolerance": TOLERANCE,
        "iterations": ITERATIONS,
        "gravity": " ".join(map(str, scene.gravity)),
    }
    chosen = " ".join(f'{name}="{value}"' for name, value in options.items())
    points = " ".join(f"{value:.17g}" for value in mesh.points.ravel())
    tets = " ".join(map(str, mesh.tets.ravel()))
    return f"""
    <mujoco>
      <option {chosen}/>
      <size memory="2G"/>
      <worldbody>
        <geom type="plane" size="10 10 1" friction="{friction}" solref="{solref}" condim="3"/>
        <flexcomp name="body" type="direct" dim="3" mass="{material.density * mesh.volume}"
                  radius="{RADIUS}" point="{points}" element="{tets}">
          <contact condim="3" friction="{friction}" solref="{solref}" selfcollide="none"/>
          <elasticity young="{material.young_modulus}" poisson="{material.poisson_ratio}"
                      damping="{material.stiffness_damping}"/>
        </flexcomp>
      </worldbody>
    </mujoco>"""
