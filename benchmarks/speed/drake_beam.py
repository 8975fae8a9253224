"""The cantilever as a deformable body of Drake, linearly corotational, in double precision.

Drake solves one linear system a step too, by its own sparse Cholesky factor. Its Python package is
called `drake`, its module `pydrake`.
"""

from __future__ import annotations

import importlib
import tempfile
from pathlib import Path
from typing import Any

import numpy as np

from warp_softbody.accuracy.runs.peers.beam import MATERIAL, Cantilever, StepReport
from warp_softbody.arrays import FloatArray
from warp_softbody.body.mesh import TetMesh

BESIDE = 1e-6
"""Height, m, of the wall over the clamped face, so that it holds that face alone."""

VTK_TETRAHEDRON = 10


class DrakeBeam:
    """A plant with one deformable body whose face x = 0 is held by a wall."""

    def __init__(self, beam: Cantilever, time_step: float) -> None:
        """Build the plant of a beam at rest."""
        library = importlib.import_module("pydrake.all")
        fem = importlib.import_module("pydrake.multibody.fem")
        builder = library.DiagramBuilder()
        plant, _ = library.AddMultibodyPlantSceneGraph(builder, time_step)
        plant.set_discrete_contact_approximation(library.DiscreteContactApproximation.kSap)
        self._deformable = plant.mutable_deformable_model()
        config = _config(fem)
        with tempfile.TemporaryDirectory() as folder:
            path = Path(folder) / "beam.vtk"
            path.write_text(_vtk(beam.mesh), encoding="ascii")
            geometry = library.GeometryInstance(
                library.RigidTransform(), library.Mesh(str(path), 1.0), "beam"
            )
            geometry.set_proximity_properties(_surface(library))
            body = self._deformable.RegisterDeformableBody(geometry, config, 1.0)
        wall = np.array([BESIDE, 0.0, 0.0])
        self._deformable.SetWallBoundaryCondition(body, wall, np.array([1.0, 0.0, 0.0]))
        plant.Finalize()
        self._simulator = library.Simulator(builder.Build())
        self._context = plant.GetMyContextFromRoot(self._simulator.get_context())
        self._state = self._deformable.GetDiscreteStateIndex(body)
        self._time_step, self._steps, self._nodes = time_step, 0, len(beam.mesh.points)
        self._simulator.Initialize()

    def step(self) -> StepReport:
        """One step."""
        self._steps += 1
        self._simulator.AdvanceTo(self._steps * self._time_step)
        return StepReport()

    def positions(self) -> FloatArray:
        """(n, 3) m, a copy."""
        state = self._context.get_discrete_state(self._state).get_value()
        return np.array(state[: 3 * self._nodes]).reshape(-1, 3)


def _config(fem: Any) -> Any:
    """The beam's material."""
    config = fem.DeformableBodyConfig()
    config.set_youngs_modulus(MATERIAL.young_modulus)
    config.set_poissons_ratio(MATERIAL.poisson_ratio)
    config.set_mass_density(MATERIAL.density)
    config.set_mass_damping_coefficient(0.0)
    config.set_stiffness_damping_coefficient(0.0)
    config.set_material_model(fem.MaterialModel.kLinearCorotated)
    return config


def _surface(library: Any) -> Any:
    """What every deformable body of Drake needs, though nothing touches the beam."""
    properties = library.ProximityProperties()
    friction = library.CoulombFriction(0.5, 0.5)
    library.AddContactMaterial(friction=friction, properties=properties)
    return properties


def _vtk(mesh: TetMesh) -> str:
    """A mesh as a legacy VTK file."""
    count = len(mesh.tets)
    lines = ["# vtk DataFile Version 3.0", "beam", "ASCII", "DATASET UNSTRUCTURED_GRID"]
    lines.append(f"POINTS {len(mesh.points)} double")
    lines += [" ".join(f"{value:.17g}" for value in point) for point in mesh.points.tolist()]
    lines.append(f"CELLS {count} {5 * count}")
    lines += [" ".join(map(str, (4, *tet))) for tet in mesh.tets.tolist()]
    lines += [f"CELL_TYPES {count}", *[str(VTK_TETRAHEDRON)] * count]
    return "\n".join(lines) + "\n"
