"""Rows and maps of one body among several: as if it were alone, in the arrays of the whole."""

from __future__ import annotations

from typing import Any, TypeVar

import numpy as np

from warp_softbody.arrays import FloatArray
from warp_softbody.errors import InputError
from warp_softbody.inputs import checks
from warp_softbody.inputs.records import unchecked_copy
from warp_softbody.world.joined_bodies import Part
from warp_softbody.world.scene import Scene

Maps = TypeVar("Maps", bound=Any)

OF_SEGMENTS = ("lengths", "reaches", "rest_lengths")


def part_named(scene: Scene, name: object) -> Part:
    """Where the body of a name stands in the arrays of the whole.

    Raises:
        InputError: there is none.
    """
    for part in scene.parts:
        if isinstance(name, str) and part.name == name:
            return part
    known = ", ".join(part.name for part in scene.parts)
    raise InputError(f"no body of the scene is named {checks.shown(name)}; there are: {known}")


def rows_of_whole(rows: FloatArray, part: Part, node_count: int) -> FloatArray:
    """Rows (k, 3n) of all nodes that act on those of a body as rows (k, 3 own) say."""
    whole = np.zeros((len(rows), 3 * node_count))
    whole[:, 3 * part.nodes.start : 3 * part.nodes.stop] = rows
    return whole


def weights_of_whole(weights: FloatArray, part: Part, node_count: int) -> FloatArray:
    """Weights (n,) of all nodes, zero but for those (own,) of a body."""
    whole = np.zeros(node_count)
    whole[part.nodes] = weights
    return whole


def of_own_segments(maps: Maps, part: Part) -> Maps:
    """Maps whose muscles are a body's own."""
    own = {name: getattr(maps, name)[part.segments] for name in OF_SEGMENTS}
    return unchecked_copy(maps, muscle_map=maps.muscle_map[:, part.segments], **own)
