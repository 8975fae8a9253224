"""Coulomb's law of one contact as a union of polyhedral cones of (force, velocity), its pieces.

With m tangent directions a contact has 2 + 2m pieces, numbered by *mode* (docs/method.md section
5):

    0          lift: no force, w_n >= 0
    1          stick: w = 0, force in the polyhedral cone
    2 .. m+1   slide j: force on the ray g_j = (1, mu S_j d_j), w_t in the cone opposite to d_j
    m+2 ..     edge j: force between g_j and g_j+1, w_t on the one ray opposite to both

Each piece is stored as matrices on (f, w) in R^6: a basis of its forces, the velocity components
that vanish, its inequality rows, its three equality rows, and the rays that generate it. Without
friction the tangent velocity is free and only lift and slide 0 exist; other modes mean slide 0
there.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property, lru_cache

import numpy as np
import numpy.typing as npt

from warp_softbody.arrays import BoolArray, FloatArray
from warp_softbody.contact_mode import ContactMode
from warp_softbody.controllers.qpcc.contact.mode_cones import frictional_shapes, frictionless_shapes
from warp_softbody.controllers.qpcc.contact.problem import ContactQPCC

IntArray = npt.NDArray[np.int64]

LIFT = int(ContactMode.LIFT)
STICK = int(ContactMode.STICK)
SLIDE = int(ContactMode.SLIDE)
"""Modes at and above this number slide."""

FRICTIONLESS = 1e-9
"""Friction coefficients up to this count as none: their cones are too thin for a stick piece."""


def contact_mode(mode: int) -> ContactMode:
    """Lift, stick or slide: what a mode number means to everybody else."""
    return ContactMode(min(mode, SLIDE))


@dataclass(frozen=True)
class PieceTable:
    """All pieces of K contacts; axis 0 is the contact, axis 1 the mode.

    Attributes:
        basis: (K, M, 3, 3), columns that span the piece's forces, zero beyond ``count``.
        still: (K, M, 3, 3), rows of the velocity that vanish, zero beyond ``count``.
        count: (K, M), dimension of the force, which is the number of still rows.
        rows: (K, M, r, 6), inequality rows on (f, w), >= 0; zero where ``row_used`` is false.
        row_used: (K, M, r).
        walls: (K, M, r + 6, 6), every condition as a row >= 0: ``rows`` and both signs of the three
            unit rows that vanish on the piece.
        rays: (K, M, s, 6), unit generators of the piece, padded with zeros.
        valid: (K, M), false for modes that repeat another one (no friction).
    """

    basis: FloatArray
    still: FloatArray
    count: IntArray
    rows: FloatArray
    row_used: BoolArray
    walls: FloatArray
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
        """(K, M): how far each contact's (f, w), (K, 6), is from satisfying each piece."""
        violation = -self._least(self._flat_walls, points)
        return violation if self._none_repeated else np.where(self.valid, violation, np.inf)

    def descent(self, slopes: FloatArray) -> FloatArray:
        """(K, M): least slope along any ray of a piece, for objective slopes (K, 6) in (f, w)."""
        return self._least(self._flat_rays, slopes)

    def _least(self, matrices: FloatArray, vectors: FloatArray) -> FloatArray:
        """(K, M): least product of a piece's rows, (K, r M, 6), with each contact's vector."""
        count, modes = self.valid.shape
        rows = matrices.shape[1] // modes
        products = (matrices @ vectors[:, :, None]).reshape(count, rows, modes)
        least: FloatArray = products.min(axis=1)
        return least

    @cached_property
    def _flat_walls(self) -> FloatArray:
        return _modes_last(self.walls)

    @cached_property
    def _flat_rays(self) -> FloatArray:
        return _modes_last(self.rays)


def _modes_last(matrices: FloatArray) -> FloatArray:
    """(K, r M, 6) from (K, M, r, 6): the least of r rows is then found for all modes at once."""
    count, modes, rows, size = matrices.shape
    flat: FloatArray = matrices.transpose(0, 2, 1, 3).reshape(count, rows * modes, size)
    return flat


def piece_table(problem: ContactQPCC) -> PieceTable:
    """The pieces of a problem's contacts; kept between steps, as they depend on friction only."""
    own = problem
    return _table(own.friction.tobytes(), own.factors.tobytes(), own.directions.tobytes())


@lru_cache(maxsize=64)
def _table(friction: bytes, factors: bytes, directions: bytes) -> PieceTable:
    mu = np.frombuffer(friction)
    m = len(directions) // 16
    radius = mu[:, None] * np.frombuffer(factors).reshape(len(mu), m)
    rough = np.any(radius > FRICTIONLESS, axis=1)
    if rough.any() and rough.all():
        shapes = frictional_shapes(radius, directions)
    else:
        shapes = frictionless_shapes(len(mu), directions)
        if rough.any():
            cones = frictional_shapes(radius[rough], directions)
            for part, rough_part in zip(shapes, cones, strict=True):
                part[rough] = rough_part
    rows, equality = shapes.rows, shapes.equality
    valid = np.ones((len(mu), 2 + 2 * m), dtype=bool)
    valid[~rough, STICK], valid[~rough, SLIDE + 1 :] = False, False
    return PieceTable(
        basis=shapes.basis,
        still=shapes.still,
        count=np.any(shapes.still, axis=3).sum(axis=2),
        rows=rows,
        row_used=shapes.used,
        walls=np.concatenate([rows, equality, -equality], axis=2),
        rays=shapes.rays,
        valid=valid,
    )
