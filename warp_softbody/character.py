"""A character: a body, what it is made of, its muscles and its named regions."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from functools import cached_property
from types import MappingProxyType

import numpy as np
import numpy.typing as npt

from warp_softbody.errors import InputError
from warp_softbody.ground_friction import DirectionalFriction, NodeFriction, friction_by_node
from warp_softbody.material import Material
from warp_softbody.mesh import TetMesh
from warp_softbody.muscles import Fiber, MuscleGroup

IntArray = npt.NDArray[np.int32]


@dataclass(frozen=True, kw_only=True)
class Character:
    """Everything about a body that does not change while it moves.

    Attributes:
        name: also the name of its prim in the stage, so a valid identifier.
        mesh: rest shape.
        material: elastic constants, density and damping.
        muscles: groups of fibres; empty for a passive body.
        regions: node indices by name ("base", "head", ...), each (k,) int32; those of the mesh
            are taken up.
        fixed: node indices that never move, (k,) int32.
        color: display colour, linear RGB in 0..1.
        directional_friction: of regions that slide more easily one way than another.
    """

    name: str
    mesh: TetMesh
    material: Material = field(default_factory=Material)
    muscles: tuple[MuscleGroup, ...] = ()
    regions: Mapping[str, IntArray] = field(default_factory=dict)
    fixed: IntArray = field(default_factory=lambda: np.zeros(0, dtype=np.int32))
    color: tuple[float, float, float] = (0.80, 0.30, 0.24)
    directional_friction: tuple[DirectionalFriction, ...] = ()

    def __post_init__(self) -> None:
        """Check the name and the index sets against the mesh."""
        if not self.name.isidentifier():
            raise InputError(f"character name must be an identifier, got {self.name!r}")
        named = {**self.mesh.regions, **self.regions}
        regions = {name: self._indices(name, nodes) for name, nodes in named.items()}
        object.__setattr__(self, "regions", MappingProxyType(regions))
        object.__setattr__(self, "fixed", self._indices("fixed", self.fixed))
        for friction in self.directional_friction:
            self.region(friction.region)

    def _indices(self, name: str, nodes: npt.ArrayLike) -> IntArray:
        checked = np.unique(np.asarray(nodes, dtype=np.int32))
        count = len(self.mesh.points)
        if checked.size and (checked[0] < 0 or checked[-1] >= count):
            raise InputError(
                f"character {self.name!r}: region {name!r} holds node {checked[-1]}, "
                f"but the mesh has {count} nodes"
            )
        checked.setflags(write=False)
        return checked

    @property
    def fibers(self) -> tuple[Fiber, ...]:
        """All fibres, in the order of the segments of the model."""
        return tuple(fiber for group in self.muscles for fiber in group.fibers)

    @property
    def segment_count(self) -> int:
        """Number of muscle segments of all groups."""
        return sum(group.segment_count for group in self.muscles)

    @cached_property
    def node_friction(self) -> NodeFriction:
        """What directional friction says of each node."""
        return friction_by_node(self)

    def region(self, name: str) -> IntArray:
        """Node indices of a named region; one sentence when there is none of that name."""
        if name not in self.regions:
            known = ", ".join(sorted(self.regions)) or "none"
            raise InputError(f"character {self.name!r} has no region {name!r}; it has: {known}")
        return self.regions[name]
