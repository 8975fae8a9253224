"""Uniform refinement: every tet into eight, with everything that stands on the mesh carried along.

The body stays what it is, to rounding: its volume, its surface as a set of points, its muscles. So
a refined scene is the same scene, of which a finer mesh knows more.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import numpy.typing as npt

from warp_softbody.body.character import Character
from warp_softbody.body.mesh_refinement import refine

IntArray = npt.NDArray[np.int32]


def refined_character(character: Character) -> Character:
    """A character on a mesh of eight times as many tets; its nodes keep their indices.

    The middle of an edge belongs to a region, or is fixed, where both ends do.
    """
    mesh, edges = refine(character.mesh)
    first = len(character.mesh.points)

    def carried(nodes: IntArray) -> IntArray:
        inside = np.zeros(first, dtype=bool)
        inside[nodes] = True
        middles = first + np.flatnonzero(inside[edges].all(axis=1))
        return np.concatenate([nodes, middles]).astype(np.int32)

    return replace(
        character,
        mesh=mesh,
        regions={name: carried(nodes) for name, nodes in character.regions.items()},
        fixed=carried(character.fixed),
    )
