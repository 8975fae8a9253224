"""The matrix of a crumpled body, and preconditioners of it, for tests against dense NumPy."""

from __future__ import annotations

from typing import Any

import numpy as np
import warp as wp

from tests.support.bodies import Rig, crumpled, rig
from tests.verification import reference
from warp_softbody.arrays import FloatArray
from warp_softbody.body.material import Material
from warp_softbody.body.mesh import TetMesh
from warp_softbody.device.workspace import Workspace
from warp_softbody.kernels.linear.codes import VelocityConstraint
from warp_softbody.linear.block_ldlt import Freedom
from warp_softbody.linear.preconditioner import Preconditioner, make_preconditioner

STIFF = Material(young_modulus=1e6, poisson_ratio=0.4, stiffness_damping=0.02)
FIXED = (0, 3, 7, 20)
NORMAL = np.array([0.6, 0.0, 0.8])


def assembled(mesh: TetMesh, fixed: Any = (), **options: Any) -> tuple[Rig, FloatArray]:
    """A rig with the matrix of a crumpled body, which is also returned with fixed nodes cut out."""
    body = rig(mesh, material=STIFF, fixed=fixed, time_step=0.01, **options)
    body.place(crumpled(mesh))
    body.stepper.assemble(body.state)
    return body, cut(reference.step_matrix(body.model, body.positions), fixed)


def cut(matrix: FloatArray, fixed: Any) -> FloatArray:
    """Rows and columns of fixed nodes replaced by the identity."""
    held = (3 * np.asarray(fixed, dtype=int)[:, None] + np.arange(3)).ravel()
    matrix[held] = 0.0
    matrix[:, held] = 0.0
    matrix[held, held] = 1.0
    return matrix


def freedom_of(body: Rig, kinds: Any = 0, slip: Any = 0.0) -> Freedom:
    """Kinds (n,) and slip stiffness (n, 3, 3) of contact; fixed nodes are held."""
    model, types, n = body.model, body.model.types, body.model.node_count
    kinds = np.where(model.fixed, VelocityConstraint.FIXED, np.broadcast_to(np.int32(kinds), n))
    return Freedom(
        model.array(kinds, wp.int32),
        model.array(np.tile(NORMAL, (n, 1)), types.vec3),
        model.array(np.broadcast_to(np.float64(slip), (n, 3, 3)), types.mat33),
    )


def factor_of(body: Rig, kinds: Any = 0, slip: Any = 0.0) -> Preconditioner:
    """The preconditioner of the matrix as assembled, on what contact leaves free."""
    assembly, freedom = body.stepper.assembly, freedom_of(body, kinds, slip)
    factor = make_preconditioner(
        body.model.system, assembly.values, assembly.node_rotations, Workspace()
    )
    factor.renew(freedom)
    factor.prepare(freedom)
    return factor


def preconditioned(body: Rig, factor: Preconditioner, vectors: FloatArray) -> FloatArray:
    """P applied to the columns of (3n, k), turned with the nodes as they are now."""
    types, n = body.model.types, body.model.node_count
    result = body.model.zeros(n, types.vec3)
    columns = []
    for column in vectors.T:
        factor.apply(body.model.array(column.reshape(n, 3), types.vec3), result)
        columns.append(result.numpy().astype(np.float64).ravel())
    return np.stack(columns, axis=1)
