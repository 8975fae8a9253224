"""Pictures of one scene's frames, one after the other, through one camera."""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

from warp_softbody.inputs import checks
from warp_softbody.stage_exports.bodies import staged_bodies
from warp_softbody.stage_exports.camera import Camera, start_box
from warp_softbody.stage_exports.pictures.render import Renderer
from warp_softbody.stage_exports.pictures.subject import Pose, Subject
from warp_softbody.world.frame import Frame
from warp_softbody.world.scene import Scene

SIZE = (480, 360)
"""Width and height, pixels."""


class FramePainter:
    """Draws frames of a scene as arrays; the camera is that of the first one."""

    def __init__(self, scene: Scene) -> None:
        """Of a scene."""
        checks.instance("scene of a FramePainter", scene, Scene)
        self._scene = scene
        self._bodies = staged_bodies(scene)
        self._renderer: Renderer | None = None

    def draw(self, frame: Frame) -> npt.NDArray[np.uint8]:
        """(height, width, 3) picture of a frame."""
        if self._renderer is None:
            camera = Camera.framing(*start_box(frame.positions), aspect=SIZE[0] / SIZE[1])
            subject = Subject.of_bodies(self._bodies, self._scene.ground)
            self._renderer = Renderer(subject, camera, SIZE)
        return np.asarray(self._renderer.draw(Pose.of_frame(frame, self._bodies)), dtype=np.uint8)
