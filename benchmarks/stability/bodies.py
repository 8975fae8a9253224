"""Bodies of the stability suite: bars on grids, one with slivers, one with a tiny tet."""

from __future__ import annotations

import itertools
from dataclasses import replace

import numpy as np
import numpy.typing as npt

from benchmarks.beam.cantilever import SIZE, beam_mesh
from warp_softbody import Character, Fiber, FiberKind, Material, MuscleGroup, TetMesh, characters
from warp_softbody.arrays import FloatArray

IntArray = npt.NDArray[np.int64]
Counts = tuple[int, int, int]

CELL = 0.1
"""Edge of a grid cell, m."""

DAMPING_RATIO = 0.45
"""Of the first bending of a bar clamped at one end, where a material is damped."""


def kuhn_cells(counts: Counts, *, alternate: Counts | None = None) -> IntArray:
    """Six tets (m, 4) for each cell of a grid of points.

    With ``alternate``, a cell is mirrored across every axis in which its index and that number
    together are odd, so that the diagonals of neighbouring cells alternate.
    """
    corner = np.stack(np.meshgrid(*map(np.arange, counts), indexing="ij"), axis=-1).reshape(-1, 3)
    mirrored = np.zeros_like(corner)
    if alternate is not None:
        mirrored = (corner + np.array(alternate)) % 2
    shape = tuple(count + 1 for count in counts)
    tets = []
    for order in itertools.permutations(range(3)):
        path = np.cumsum([np.zeros(3, int), *np.eye(3, dtype=int)[list(order)]], axis=0)
        turned = np.where(mirrored[:, None] == 1, 1 - path, path)
        tets.append(
            np.ravel_multi_index(tuple(np.moveaxis(corner[:, None] + turned, -1, 0)), shape)
        )
    return np.concatenate(tets)


def grid_points(counts: Counts) -> FloatArray:
    """Points of a grid of cells of edge 1 from the origin on, in the order of ``kuhn_cells``."""
    axes = [np.arange(count + 1.0) for count in counts]
    return np.stack(np.meshgrid(*axes, indexing="ij"), axis=-1).reshape(-1, 3)


def bar_mesh(counts: Counts = (6, 2, 2)) -> TetMesh:
    """A bar of 0.6 x 0.2 x 0.2 m, 144 tets, unless told otherwise."""
    return TetMesh.from_arrays(CELL * grid_points(counts), kuhn_cells(counts))


def sliver_mesh(angle: float) -> TetMesh:
    """Two halves of 3 x 2 x 2 cells, 148 tets, with a sliver in each of the four quads between.

    The diagonals of the halves' facing quads cross; the four corners of a quad are moved in turn
    forth and back along x until the smallest dihedral angle of the sliver is ``angle`` degrees.
    """
    counts = (3, 2, 2)
    left = grid_points(counts) * [-1.0, 1.0, 1.0]
    right = grid_points(counts)
    # shifted by one cell, alternating diagonals cross
    tets = [
        kuhn_cells(counts, alternate=(0, 0, 0)),
        kuhn_cells(counts, alternate=(0, 1, 0)) + len(left),
    ]
    facing = np.arange(9).reshape(3, 3)
    ring = [facing[:-1, :-1], facing[1:, :-1], facing[1:, 1:], facing[:-1, 1:]]
    tets.append(np.stack(ring, axis=-1).reshape(-1, 4))
    points = np.concatenate([left, right])
    parity = 2.0 * ((points[:, 1] + points[:, 2]) % 2) - 1.0

    def moved(step: float) -> TetMesh:
        shift = np.where(points[:, 0] == 0.0, step * parity, 0.0)
        shifted = points + np.outer(shift, [1.0, 0.0, 0.0])
        return TetMesh.from_arrays(CELL * shifted, np.concatenate(tets))

    # so flat a sliver's angle is proportional to the step
    return moved(1e-3 * angle / moved(1e-3).smallest_dihedral_angle)


def tiny_tet_mesh(scale: float = 1e-2) -> TetMesh:
    """A bar one of whose tets holds a copy of itself, ``scale`` of its size, and a shell of 12."""
    bar = bar_mesh()
    chosen = len(bar.tets) // 2
    outer = np.sort(bar.tets[chosen])
    center = bar.points[outer].mean(axis=0)
    inner = len(bar.points) + np.arange(4)
    tets = [inner]
    for left_out in range(4):
        a, b = np.delete(outer, left_out), np.delete(inner, left_out)
        # a prism between two faces; ascending order makes the prisms' diagonals agree
        tets += [np.append(a, b[2]), np.array([a[0], a[1], b[1], b[2]]), np.append(a[:1], b)]
    points = np.concatenate([bar.points, center + scale * (bar.points[outer] - center)])
    return TetMesh.from_arrays(points, np.concatenate([np.delete(bar.tets, chosen, 0), tets]))


def bending_frequency(mesh: TetMesh, material: Material) -> float:
    """First bending of a slender bar along x clamped at one end, rad/s (Euler and Bernoulli)."""
    length, height = np.ptp(mesh.points[:, 0]), np.ptp(mesh.points[:, 2])
    speed = np.sqrt(material.young_modulus / (12.0 * material.density))
    return float(3.516 * height / length**2 * speed)


def body(
    mesh: TetMesh,
    *,
    young_modulus: float = 1e6,
    poisson_ratio: float = 0.4,
    density: float = 1000.0,
    clamped: bool = True,
    damped: bool = True,
) -> Character:
    """A body without muscles, clamped at its lowest x or free."""
    material = Material(
        young_modulus=young_modulus,
        poisson_ratio=poisson_ratio,
        density=density,
        stiffness_damping=0.0,
    )
    if damped:
        frequency = bending_frequency(mesh, material)
        material = replace(material, stiffness_damping=2.0 * DAMPING_RATIO / frequency)
    held = mesh.points[:, 0] < mesh.bounds[0, 0] + 1e-9
    fixed = np.flatnonzero(held if clamped else np.zeros_like(held)).astype(np.int32)
    regions = {"all": np.arange(len(mesh.points), dtype=np.int32)}
    return Character(name="body", mesh=mesh, material=material, fixed=fixed, regions=regions)


def beam(*, damped: bool = True) -> Character:
    """The cantilever of 1 x 0.2 x 0.2 m and 810 tets that other programs were run on."""
    mesh = beam_mesh(3)
    assert np.allclose(mesh.bounds[1], SIZE)
    return body(mesh, damped=damped)


def muscular_bar(strength: float, *, damped: bool = True) -> Character:
    """A free bar of E = 2e5 Pa with two fibres of six segments along x and a strength in Pa."""
    mesh = bar_mesh()
    fibers = tuple(
        Fiber(
            vertices=np.linspace((0.01, y, 0.1), (0.59, y, 0.1), 7),
            kind=FiberKind.LONGITUDINAL,
            name=f"fiber_{side}",
        )
        for side, y in enumerate((0.04, 0.16))
    )
    group = MuscleGroup(fibers=fibers, strength=strength, kernel_width=0.08, name="both")
    return replace(body(mesh, young_modulus=2e5, clamped=False, damped=damped), muscles=(group,))


def letter() -> Character:
    """The shipped letter I."""
    return characters.letter_i()
