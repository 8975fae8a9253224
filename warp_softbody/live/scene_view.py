"""Frames of a scene become moments that a page shows."""

from __future__ import annotations

import numpy as np

from warp_softbody.arrays import FloatArray
from warp_softbody.live.measures import CharacterMeasures
from warp_softbody.live.outline import (
    SceneOutline,
    scene_segments,
    shown_bodies,
    shown_nodes,
)
from warp_softbody.live.wire import Moment
from warp_softbody.world.frame import Frame
from warp_softbody.world.ground import Ground, Plane
from warp_softbody.world.scene import Scene


class SceneView:
    """What is shown of a scene.

    Attributes:
        scene: what is shown.
        outline: told once.
        nodes: (k,) nodes whose positions are told.
        measures: of the character.
    """

    def __init__(self, scene: Scene, *, name: str, fps: float, more: tuple[str, ...] = ()) -> None:
        """Of a scene; ``more`` are names of numbers that the caller adds to each moment."""
        self.scene = scene
        self.nodes = shown_nodes(scene)
        self._own = scene.parts[0]
        self.measures = character_measures(scene)
        segments, points = scene_segments(scene)
        self.outline = SceneOutline(
            name=name,
            fps=fps,
            bodies=shown_bodies(scene),
            points=np.asarray(scene.whole.mesh.points)[self.nodes],
            segments=segments,
            fiber_points=points,
            ground=scene.ground,
            numbers=(*self.measures.names, *more),
            weight=self.measures.weight,
        )

    def moment(self, frame: Frame, more: FloatArray | None = None) -> Moment:
        """What is shown of a frame, with the numbers that the caller adds."""
        own = self._own
        measured = self.measures.of(
            frame.positions[own.nodes],
            frame.velocities[own.nodes],
            1.0 - frame.activations[own.segments],
            frame.contacts.seen_by(0, frame.positions),
        )
        return Moment(
            time=frame.time,
            surface=frame.positions[self.nodes],
            fibers=frame.fiber_points,
            contraction=1.0 - frame.activations,
            contacts=frame.contacts,
            patches=frame.patches,
            numbers=measured if more is None else np.concatenate([measured, more]),
        )


def character_measures(scene: Scene) -> CharacterMeasures:
    """Measures of a scene's character."""
    character = scene.character
    masses = character.node_masses
    normal, offset = level_of(scene.ground)
    return CharacterMeasures(
        masses / masses.sum(),
        float(masses.sum()),
        gravity=scene.gravity,
        normal=normal,
        offset=offset,
    )


def level_of(ground: Ground | None) -> tuple[tuple[float, float, float] | None, float | None]:
    """Normal of a ground, and the offset along it of a plane."""
    if ground is None:
        return None, None
    return ground.normal, ground.offset if isinstance(ground, Plane) else None
