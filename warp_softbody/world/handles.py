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
        until: s, when it lets go: steps that begin then or later are free, and begin with the
            velocities that it gave. None where it never does.
    """

    region: str
    path: MotionPath
    until: float | None = None

    def __post_init__(self) -> None:
        """Refuse a name, a path or a time that is none."""
        input_kinds.name("Handle.region", self.region)
        checks.instance("Handle.path", self.path, MotionPath)
        if self.until is not None:
            until = checks.number("Handle.until", self.until, low=0.0, unit="s")
            checks.keep(self, until=until)

    def holds(self, start: float, duration: float) -> bool:
        """Whether it moves its nodes in a step that begins at a time and lasts so long, s."""
        # a time step has no finite binary fraction, so that sums of it miss times by rounding
        return self.until is None or self.until - start > 1e-6 * duration


def nodes_named(name: str, whole: Character, parts: Iterable[Part]) -> IntArray:
    """Nodes of a region of the joined bodies, or of the whole body of that name.

    Raises:
        InputError: there is neither, or both of that name and not of the same nodes.
    """
    bodies = {part.name: part.nodes for part in parts}
    region = whole.regions.get(name)
    if name in bodies:
        body = np.arange(bodies[name].start, bodies[name].stop, dtype=np.int32)
        if region is not None and not np.array_equal(region, body):
            raise InputError(
                f"{name!r} is the name of a body and of a region of other nodes; give one of them "
                "another name"
            )
        return body
    if region is not None:
        return region
    known = ", ".join([*sorted(whole.regions), *bodies])
    raise InputError(f"no region or body of the scene is named {name!r}; it has: {known}")


def acted_on(name: str, whole: Character, parts: Iterable[Part]) -> IntArray:
    """Nodes (k,) of a region or a body by its name, on which something acts.

    Raises:
        InputError: there is none of that name, or it has no nodes.
    """
    return _some(name, nodes_named(name, whole, parts))


def pushed_nodes(name: str, whole: Character) -> IntArray:
    """Nodes (k,) of a region of the joined bodies, which may be pushed.

    Raises:
        InputError: there is none of that name, or it has no nodes.
    """
    return _some(name, whole.region(name))


def _some(name: str, nodes: IntArray) -> IntArray:
    if not len(nodes):
        raise InputError(f"the region {name!r} has no nodes, so nothing can act on it")
    return nodes


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
