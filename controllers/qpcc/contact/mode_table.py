"""Coulomb's law of a contact as a union of polyhedral cones of (force, velocity), one a mode.

With m tangent directions a contact has 2 + 2m modes (docs/method.md section 5):

    0          lift: no force, w_n >= 0
    1          stick: w = 0, force in the polyhedral cone
    2 .. m+1   slide j: force on the ray g_j = (1, mu S_j d_j), w_t in the cone opposite to d_j
    m+2 ..     edge j: force between g_j and g_j+1, w_t on the one ray opposite to both

The cone of a mode is stored as matrices on (f, w) in R^6: a basis of its forces, the constraints on
its velocity, its inequalities, and its extreme rays. Without friction the tangent velocity is free
and only lift and slide 0 exist; the other modes then repeat slide 0.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property, lru_cache

import numpy as np
import numpy.typing as npt

from warp_softbody.arrays import BoolArray, FloatArray
from warp_softbody.contact_mode import ContactMode
from warp_softbody.controllers.qpcc.contact.mode_cones import frictional_cones, frictionless_cones
from warp_softbody.controllers.qpcc.contact.problem import ContactQPCC

IntArray = npt.NDArray[np.int64]

LIFT = int(ContactMode.LIFT)
STICK = int(ContactMode.STICK)
SLIDE = int(ContactMode.SLIDE)
"""Modes at and above this number slide."""

FRICTIONLESS = 1e-9
"""Friction coefficients up to this count as none: their cones are too thin for a stick mode."""


@dataclass(frozen=True)
class ModeTable:
    """The cones of all modes of K contacts; axis 0 is the contact, axis 1 the mode.

    Attributes:
        force_basis: (K, M, 3, 3), columns that span the forces, zero beyond ``force_dimensions``.
        velocity_constraints: (K, M, 3, 3), rows T with T w = 0, zero beyond ``force_dimensions``.
        force_dimensions: (K, M), dimension of the force; the velocity has as many constraints.
        inequalities: (K, M, r, 6), rows on (f, w), >= 0; zero where not ``inequality_used``.
        inequality_used: (K, M, r).
        halfspaces: (K, M, r + 6, 6), all conditions as rows >= 0: the inequalities, and both signs
            of the three unit rows that vanish on the cone.
        rays: (K, M, s, 6), unit extreme rays of the cone, padded with zeros.
        valid: (K, M), false for modes that repeat another one (no friction).
    """

    force_basis: FloatArray
    velocity_constraints: FloatArray
    force_dimensions: IntArray
    inequalities: FloatArray
    inequality_used: BoolArray
    halfspaces: FloatArray
    rays: FloatArray
    valid: BoolArray

    def canonical(self, modes: tuple[int, ...]) -> tuple[int, ...]:
        """The same modes with repeated ones replaced by slide 0."""
        if self._none_repeated:
            return modes
        return tuple(
            mode if self.valid[contact, mode] else SLIDE for contact, mode in enumerate(modes)
        )

    @cached_property
    def _none_repeated(self) -> bool:
        return bool(self.valid.all())

    def violation(self, points: FloatArray) -> FloatArray:
        """(K, M): by how much each contact's (f, w), (K, 6), violates the conditions of a mode."""
        violation = -self._least(self._flat_halfspaces, points)
        return violation if self._none_repeated else np.where(self.valid, violation, np.inf)

    def least_slopes(self, slopes: FloatArray) -> FloatArray:
        """(K, M): least derivative of the objective along an extreme ray of each mode.

        ``slopes`` (K, 6) are the derivatives in (f, w).
        """
        return self._least(self._flat_rays, slopes)

    def _least(self, matrices: FloatArray, vectors: FloatArray) -> FloatArray:
        """(K, M): least product of a mode's rows, (K, r M, 6), with the contact's vector (K, 6)."""
        count, modes = self.valid.shape
        rows = matrices.shape[1] // modes
        products = (matrices @ vectors[:, :, None]).reshape(count, rows, modes)
        least: FloatArray = products.min(axis=1)
        return least

    @cached_property
    def _flat_halfspaces(self) -> FloatArray:
        return _modes_last(self.halfspaces)

    @cached_property
    def _flat_rays(self) -> FloatArray:
        return _modes_last(self.rays)


def _modes_last(matrices: FloatArray) -> FloatArray:
    """(K, r M, 6) from (K, M, r, 6): the least of r rows is then found for all modes at once."""
    count, modes, rows, size = matrices.shape
    flat: FloatArray = matrices.transpose(0, 2, 1, 3).reshape(count, rows * modes, size)
    return flat


def mode_table(problem: ContactQPCC) -> ModeTable:
    """The modes of a problem's contacts; kept between steps, as they depend on friction only."""
    own = problem
    return _table(own.friction.tobytes(), own.factors.tobytes(), own.directions.tobytes())


@lru_cache(maxsize=64)
def _table(friction: bytes, factors: bytes, directions: bytes) -> ModeTable:
    mu = np.frombuffer(friction)
    m = len(directions) // 16
    radius = mu[:, None] * np.frombuffer(factors).reshape(len(mu), m)
    rough = np.any(radius > FRICTIONLESS, axis=1)
    if rough.any() and rough.all():
        cones = frictional_cones(radius, directions)
    else:
        cones = frictionless_cones(len(mu), directions)
        if rough.any():
            rough_cones = frictional_cones(radius[rough], directions)
            for part, rough_part in zip(cones, rough_cones, strict=True):
                part[rough] = rough_part
    rows, equality = cones.inequalities, cones.equalities
    valid = np.ones((len(mu), 2 + 2 * m), dtype=bool)
    valid[~rough, STICK], valid[~rough, SLIDE + 1 :] = False, False
    return ModeTable(
        force_basis=cones.force_basis,
        velocity_constraints=cones.velocity_constraints,
        force_dimensions=np.any(cones.velocity_constraints, axis=3).sum(axis=2),
        inequalities=rows,
        inequality_used=cones.inequality_used,
        halfspaces=np.concatenate([rows, equality, -equality], axis=2),
        rays=cones.rays,
        valid=valid,
    )
