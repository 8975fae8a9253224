"""What one simulation of a batch has of its own."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from types import MappingProxyType
from typing import TypeAlias

import numpy as np

from warp_softbody.controllers.controller import Controller
from warp_softbody.controllers.inner_controllers import two_with_one
from warp_softbody.engine.model_sharing import same_meshes
from warp_softbody.errors import InputError
from warp_softbody.inputs import checks, input_kinds
from warp_softbody.world.scene import Scene


@dataclass(frozen=True, kw_only=True, eq=False)
class BatchMember:
    """One of the many simulations of a `Batch`, before it begins.

    Attributes:
        index: in the batch, from 0.
        scene: with the member's own pushes, material values, gravity, velocities or ground; its
            meshes are those of all members.
        controller: the member's own, which no other member has; None for a passive one.
        others: controllers of bodies beside the character, by their names, as of a `Simulation`;
            they too are the member's own.
        random: random numbers of the member alone: the same for the same seed of the batch and the
            same index, however many members there are.
    """

    index: int
    scene: Scene
    controller: Controller | None = None
    others: Mapping[str, Controller] = field(default_factory=dict)
    random: np.random.Generator

    def __post_init__(self) -> None:
        """Refuse what cannot be simulated."""
        index = checks.whole("BatchMember.index", self.index)
        checks.instance("BatchMember.scene", self.scene, Scene)
        if self.controller is not None:
            input_kinds.controller("BatchMember.controller", self.controller)
        others = input_kinds.mapping("BatchMember.others", self.others)
        for name, other in others.items():
            input_kinds.controller(f"BatchMember.others[{name!r}]", other)
        checks.instance("BatchMember.random", self.random, np.random.Generator)
        checks.keep(self, index=index, others=MappingProxyType(dict(others)))

    @property
    def controllers(self) -> tuple[Controller, ...]:
        """All of the member, the character's first."""
        own = () if self.controller is None else (self.controller,)
        return (*own, *self.others.values())


Vary: TypeAlias = Callable[[BatchMember], BatchMember]
"""Gives a member what it has of its own; by `dataclasses.replace` for instance."""


def members_of(scene: Scene, count: int, vary: Vary | None, seed: int) -> tuple[BatchMember, ...]:
    """The members of a batch, each with a controller and random numbers of its own.

    Raises:
        InputError: ``vary`` returns no member, one of other meshes, or another one's controller.
    """
    found: list[BatchMember] = []
    for index in range(count):
        random = np.random.default_rng([seed, index])
        member = BatchMember(index=index, scene=scene, random=random)
        if vary is not None:
            member = _varied(vary, member)
        if not same_meshes(member.scene, scene):
            raise InputError(
                f"member {index} of a Batch has other bodies or meshes than its scene; "
                "members may differ in all else"
            )
        found.append(member)
    pair = two_with_one(member.controllers for member in found)
    if pair is not None:
        raise InputError(
            f"members {pair[0]} and {pair[1]} of a Batch have one controller, which remembers its "
            "steps; let vary make one for each"
        )
    return tuple(found)


def _varied(vary: Vary, member: BatchMember) -> BatchMember:
    label = f"vary of a Batch for member {member.index}"
    try:
        found = vary(member)
    except TypeError as error:
        raise InputError(f"{label} cannot be called: {error}") from error
    return checks.instance(f"what {label} returns", found, BatchMember)
