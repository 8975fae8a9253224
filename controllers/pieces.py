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
from functools import lru_cache

import numpy as np
import numpy.typing as npt

from warp_softbody.controllers.qpcc import ContactQPCC, FloatArray
from warp_softbody.frame import ContactMode

BoolArray = npt.NDArray[np.bool_]
IntArray = npt.NDArray[np.int64]

LIFT = int(ContactMode.LIFT)
STICK = int(ContactMode.STICK)
SLIDE = int(ContactMode.SLIDE)
"""Modes at and above this number slide."""

FRICTIONLESS = 1e-9
"""Friction coefficients up to this count as none: their cones are too thin for a stick piece."""

NORMAL = np.array([1.0, 0.0, 0.0])


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
        return tuple(
            mode if self.valid[contact, mode] else SLIDE for contact, mode in enumerate(modes)
        )

    def violation(self, points: FloatArray) -> FloatArray:
        """(K, M): how far each contact's (f, w), (K, 6), is from satisfying each piece."""
        return np.where(self.valid, -_apply(self.walls, points).min(axis=2), np.inf)

    def descent(self, slopes: FloatArray) -> FloatArray:
        """(K, M): least slope along any ray of a piece, for objective slopes (K, 6) in (f, w)."""
        least: FloatArray = _apply(self.rays, slopes).min(axis=2)
        return least


def _apply(matrices: FloatArray, vectors: FloatArray) -> FloatArray:
    """(K, M, r) from (K, M, r, 6) and (K, 6): one matrix-vector product per contact."""
    k, modes, rows, size = matrices.shape
    flat = matrices.reshape(k, modes * rows, size) @ vectors[:, :, None]
    return flat.reshape(k, modes, rows)


def piece_table(problem: ContactQPCC) -> PieceTable:
    """The pieces of a problem's contacts; kept between steps, as they depend on friction only."""
    return _table(problem.friction.tobytes(), problem.scale.tobytes(), problem.directions.tobytes())


@lru_cache(maxsize=64)
def _table(friction: bytes, scale: bytes, directions: bytes) -> PieceTable:
    plane = np.frombuffer(directions).reshape(-1, 2)
    mu = np.frombuffer(friction)
    radii = mu[:, None] * np.frombuffer(scale).reshape(len(mu), len(plane))
    contacts = [_contact_pieces(row.tobytes(), directions) for row in radii]
    if not contacts:
        empty = _contact_pieces(np.ones(len(plane)).tobytes(), directions)
        return PieceTable(*(np.stack([array])[:0] for array in empty))
    return PieceTable(*(np.stack(arrays) for arrays in zip(*contacts, strict=True)))


@dataclass(frozen=True)
class _Piece:
    """One piece as lists of 3-vectors; see PieceTable."""

    basis: list[FloatArray]
    force_zero: list[FloatArray]
    still: list[FloatArray]
    force_rows: list[FloatArray]
    velocity_rows: list[FloatArray]
    force_rays: list[FloatArray]
    velocity_rays: list[FloatArray]


def _unit(vector: FloatArray) -> FloatArray:
    unit: FloatArray = vector / np.linalg.norm(vector)
    return unit


def _tangent(vector: FloatArray) -> FloatArray:
    return np.concatenate([np.zeros(1), _unit(vector)])


@lru_cache(maxsize=64)
def _contact_pieces(radii: bytes, directions: bytes) -> tuple[npt.NDArray[np.generic], ...]:
    radius = np.frombuffer(radii)
    plane = np.frombuffer(directions).reshape(-1, 2)
    axes = list(np.eye(3))
    plane_rays = [axes[1], axes[2], -axes[1], -axes[2]]
    lift = _Piece([], axes, [], [], [NORMAL], [], [NORMAL, *plane_rays])
    if not np.any(radius > FRICTIONLESS):
        slip = _Piece([NORMAL], axes[1:], [NORMAL], [NORMAL], [], [NORMAL], plane_rays)
        pieces = [lift, *([slip] * (2 * len(plane) + 1))]
        valid = np.zeros(len(pieces), dtype=bool)
        valid[[LIFT, SLIDE]] = True
    else:
        pieces = [lift, *_frictional_pieces(radius, plane)]
        valid = np.ones(len(pieces), dtype=bool)
    return (*_pack(pieces, len(plane)), valid)


def _frictional_pieces(radius: FloatArray, plane: FloatArray) -> list[_Piece]:
    """Stick, the slides and the edges of one contact with ``radius`` = mu S_j."""
    m, axes = len(plane), list(np.eye(3))
    rays = [np.r_[1.0, r * d] for r, d in zip(radius, plane, strict=True)]
    away = [_tangent(-(plane[j] + plane[(j + 1) % m])) for j in range(m)]
    facets = _cone_facets(rays)
    pieces = [_Piece(axes, [], axes, facets, [], [_unit(g) for g in rays], [])]
    for j, g in enumerate(rays):
        perpendicular = np.array([-plane[j][1], plane[j][0]])
        force_zero = [
            _unit(np.r_[-radius[j], plane[j]]),
            np.r_[0.0, perpendicular],
        ]
        toward = [_tangent(plane[i % m] - plane[j]) for i in (j - 1, j + 1)]
        pieces.append(
            _Piece([g], force_zero, [NORMAL], [NORMAL], toward, [_unit(g)], [away[j - 1], away[j]])
        )
    for j, g in enumerate(rays):
        other = rays[(j + 1) % m]
        inside = [_unit(row) for row in np.linalg.pinv(np.stack([g, other], axis=1))]
        still = [NORMAL, _tangent(plane[j] - plane[(j + 1) % m])]
        between = [_unit(np.cross(g, other))]
        ends = [_unit(g), _unit(other)]
        pieces.append(_Piece([g, other], between, still, inside, [away[j]], ends, [away[j]]))
    return pieces


def _cone_facets(rays: list[FloatArray]) -> list[FloatArray]:
    """Inward unit normals of the facets of the cone that the rays generate around the normal."""
    stack = np.stack(rays)
    facets: list[FloatArray] = []
    for i, first in enumerate(rays):
        for second in rays[i + 1 :]:
            normal = np.cross(first, second)
            size = float(np.linalg.norm(normal))
            if size < 1e-12 or abs(normal[0]) < 1e-12 * size:
                continue
            normal *= np.sign(normal[0]) / size
            if np.min(stack @ normal) >= -1e-10 and not any(
                np.allclose(normal, known, atol=1e-9) for known in facets
            ):
                facets.append(normal)
    return facets


def _pack(pieces: list[_Piece], m: int) -> tuple[npt.NDArray[np.generic], ...]:
    """Pad the lists of all pieces into arrays."""
    row_count, ray_count = max(m, 3), max(m, 5)
    basis, still = np.zeros((len(pieces), 3, 3)), np.zeros((len(pieces), 3, 3))
    rows, used = np.zeros((len(pieces), row_count, 6)), np.zeros((len(pieces), row_count), bool)
    equality, rays = np.zeros((len(pieces), 3, 6)), np.zeros((len(pieces), ray_count, 6))
    for i, piece in enumerate(pieces):
        for j, vector in enumerate(piece.basis):
            basis[i, :, j] = vector
        still[i, : len(piece.still)] = np.reshape(piece.still, (-1, 3))
        for target, force_side, velocity_side in (
            (rows[i], piece.force_rows, piece.velocity_rows),
            (equality[i], piece.force_zero, piece.still),
            (rays[i], piece.force_rays, piece.velocity_rays),
        ):
            split, end = len(force_side), len(force_side) + len(velocity_side)
            target[:split, :3] = np.reshape(force_side, (-1, 3))
            target[split:end, 3:] = np.reshape(velocity_side, (-1, 3))
        used[i, : len(piece.force_rows) + len(piece.velocity_rows)] = True
    count = np.array([len(piece.basis) for piece in pieces])
    walls = np.concatenate([rows, equality, -equality], axis=1)
    return basis, still, count, rows, used, walls, rays
