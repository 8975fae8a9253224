"""A body that stands, at rest: its sole, and where its centre of mass is over it."""

from __future__ import annotations

import numpy as np

from warp_softbody.arrays import FloatArray
from warp_softbody.body.character import Character
from warp_softbody.body.mesh_geometry import lumped_masses


def sole_triangles(
    character: Character, base: str
) -> np.ndarray[tuple[int, ...], np.dtype[np.int32]]:
    """Triangles (f, 3) of the skin that lie in the base."""
    surface = character.mesh.surface
    return surface[np.isin(surface, character.region(base)).all(axis=1)]


def stance_of(character: Character) -> tuple[float, float]:
    """Where (2,) L the centre of mass rests over the base, from the mean of its nodes."""
    mesh = character.mesh
    middle = middle_at_rest(character) - mesh.points[character.region("base")].mean(axis=0)
    x, y, _ = middle / float(np.ptp(mesh.bounds, axis=0).max())
    return float(x), float(y)


def middle_at_rest(character: Character) -> FloatArray:
    """Centre of mass (3,) m at rest."""
    mesh = character.mesh
    mass = lumped_masses(mesh.tets, mesh.volumes, len(mesh.points))
    return np.asarray(mass @ mesh.points / mass.sum())
