"""What a model may take over from another one of the same meshes, so that copies cost little."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import numpy.typing as npt

from warp_softbody.body.character import Character
from warp_softbody.body.muscles import MuscleGroup
from warp_softbody.engine.linear_system import Levels
from warp_softbody.engine.muscle_layout import MuscleLayout
from warp_softbody.engine.options import SimulationOptions
from warp_softbody.linear.system import LinearSystem
from warp_softbody.world.scene import Scene


def same_meshes(scene: Scene, other: Scene) -> bool:
    """Whether two scenes have bodies of the same meshes, in the same order."""
    if len(scene.characters) != len(other.characters):
        return False
    pairs = zip(scene.characters, other.characters, strict=True)
    return all(a.mesh is b.mesh or a.mesh == b.mesh for a, b in pairs)


def same_arrays(options: SimulationOptions, other: SimulationOptions) -> bool:
    """Whether constant arrays of one may serve the other: of one precision, on one device."""
    return (options.precision, options.device) == (other.precision, other.device)


def shared_levels(
    system: LinearSystem,
    options: SimulationOptions,
    other: SimulationOptions,
    fixed: npt.NDArray[np.bool_],
    others_fixed: npt.NDArray[np.bool_],
) -> Levels | None:
    """What is factorised, as in a system with the same pattern; None where it is something else.

    ``fixed`` and ``others_fixed`` (n,) bool are the nodes that do not move.
    """
    if options.preconditioner != other.preconditioner or (fixed != others_fixed).any():
        return None
    aggregation = None if system.coarse is None else system.coarse.aggregation
    return Levels(elimination=system.elimination, aggregation=aggregation)


def shared_layout(
    layout: MuscleLayout, scene: Scene, characters: tuple[Character, ...]
) -> MuscleLayout | None:
    """The layout of the muscles of ``characters``, for those of a scene with the same meshes.

    The same object where all is equal, one with other stiffnesses where strengths alone differ, and
    None where fibres or widths do.
    """
    strengths, equal = [], True
    for own, other in zip(scene.characters, characters, strict=True):
        if len(own.muscles) != len(other.muscles):
            return None
        for group, others in zip(own.muscles, other.muscles, strict=True):
            if not _same_but_strength(group, others):
                return None
            equal &= group.strength == others.strength
            strengths.append(np.full(group.segment_count, group.strength))
    if equal:
        return layout
    return replace(layout, stiffness=np.concatenate(strengths) / layout.rest_lengths)


def _same_but_strength(group: MuscleGroup, other: MuscleGroup) -> bool:
    return group is other or replace(group, strength=other.strength) == other
