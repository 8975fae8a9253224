"""A `Handle` moves nodes along a path, whatever acts on them, and they push what they meet."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from warp_softbody.body.character import Character
from warp_softbody.errors import InputError
from warp_softbody.inputs import checks, input_kinds
from warp_softbody.world.joined_bodies import Part
from warp_softbody.world.motion_path import MotionPath

IntArray = npt.NDArray[np.int32]


@dataclass(frozen=True, kw_only=True)
class Handle:
    """Nodes that are held and moved along a path; contact takes them for what moves like that.

    Attributes:
        region: name of a region of the scene ("hand", or "ball.top" of a body beside the
            character), or of a body, all of whose nodes are moved.
        path: of the nodes, from where they are at rest.
    """

    region: str
    path: MotionPath

    def __post_init__(self) -> None:
        """Refuse a name or a path that is none."""
        input_kinds.name("Handle.region", self.region)
        checks.instance("Handle.path", self.path, MotionPath)


def nodes_named(name: str, whole: Character, parts: Iterable[Part]) -> IntArray:
    """Nodes of a region of the joined bodies, or of the whole body of that name.

    Raises:
        InputError: there is neither.
    """
    if name in whole.regions:
        return whole.regions[name]
    bodies = {part.name: part.nodes for part in parts}
    if name in bodies:
        return np.arange(bodies[name].start, bodies[name].stop, dtype=np.int32)
    known = ", ".join([*sorted(whole.regions), *bodies])
    raise InputError(f"no region or body of the scene is named {name!r}; it has: {known}")


def nodes_of_handles(
    handles: tuple[Handle, ...], whole: Character, parts: tuple[Part, ...]
) -> tuple[IntArray, ...]:
    """The nodes of each handle.

    Raises:
        InputError: a handle has no nodes, or one that another holds, or that is fixed.
    """
    owner: dict[int, str] = dict.fromkeys(whole.fixed.tolist(), "")
    found = []
    for handle in handles:
        nodes = nodes_named(handle.region, whole, parts)
        if not len(nodes):
            raise InputError(f"the region {handle.region!r} of a Handle has no nodes")
        for node in nodes.tolist():
            if node in owner:
                other = owner[node]
                also = f"the Handle of {other!r} holds too" if other else "is fixed"
                raise InputError(f"the Handle of {handle.region!r} holds node {node}, which {also}")
            owner[node] = handle.region
        found.append(nodes)
    return tuple(found)
