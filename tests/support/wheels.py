"""A rigid wheel, as a controller sees it."""

from __future__ import annotations

import numpy as np

from warp_softbody.arrays import FloatArray
from warp_softbody.characters import letter_o
from warp_softbody.world.ground import Plane
from warp_softbody.world.scene import Scene
from warp_softbody.world.view import BodyView

SCENE = Scene(character=letter_o(), ground=Plane())
STEP = 1.0 / 60.0  # s


def wheel(time: float, angle: float, speed: float) -> BodyView:
    """Letter O as a rigid wheel of 0.5 m that has rolled by an angle at a speed, rad and rad/s."""
    rest = SCENE.character.mesh.points
    middle = np.array([0.0, 0.0, 0.5])
    cosine, sine = np.cos(angle), np.sin(angle)
    turn = np.array([[cosine, 0.0, sine], [0.0, 1.0, 0.0], [-sine, 0.0, cosine]])
    arms = (rest - middle) @ turn.T
    way = np.array([0.5 * angle, 0.0, 0.0])
    spin: FloatArray = speed * np.stack([arms[:, 2], np.zeros(len(arms)), -arms[:, 0]], axis=1)
    return BodyView(
        scene=SCENE,
        time=time,
        time_step=STEP,
        masses=np.full(len(rest), 0.1),
        positions=middle + way + arms,
        velocities=spin + np.array([0.5 * speed, 0.0, 0.0]),
        touching=np.zeros(len(rest), dtype=bool),
        activations=np.ones(SCENE.character.segment_count),
    )
