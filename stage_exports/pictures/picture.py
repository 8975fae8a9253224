"""One frame is drawn as a PNG, without a display."""

from __future__ import annotations

from pathlib import Path

from warp_softbody.atomic_files import replacing
from warp_softbody.errors import InputError, OutputError
from warp_softbody.inputs import checks
from warp_softbody.stage_exports.bodies import staged_bodies
from warp_softbody.stage_exports.camera import Camera, start_box
from warp_softbody.stage_exports.conventions import checked_target
from warp_softbody.stage_exports.pictures.libraries import imageio
from warp_softbody.stage_exports.pictures.render import Image, Renderer
from warp_softbody.stage_exports.pictures.subject import Pose, Subject
from warp_softbody.world.frame import Frame
from warp_softbody.world.scene import Scene

Size = tuple[int, int]
DEFAULT_SIZE: Size = (960, 720)


def draw_picture(
    path: str | Path, scene: Scene, frame: Frame, *, size: Size = DEFAULT_SIZE
) -> Path:
    """Draw a frame through the camera that frames it; returns the file's path.

    Args:
        path: ends in .png; an existing file is replaced in one step.
        scene: what the frame is a snapshot of.
        frame: what is drawn.
        size: width and height, pixels.
    """
    checks.instance("scene of a picture", scene, Scene)
    checks.instance("frame of a picture", frame, Frame)
    size = checked_size(size)
    target = checked_target(path, extensions=(".png",))
    bodies = staged_bodies(scene)
    pose = Pose.of_frame(frame, bodies)
    camera = Camera.framing(*start_box(frame.positions), aspect=size[0] / size[1])
    renderer = Renderer(Subject.of_bodies(bodies, scene.ground), camera, size)
    save_png(target, renderer.draw(pose))
    return target


def checked_size(size: object) -> Size:
    """Width and height of a picture that can be drawn."""
    wanted = "two whole numbers of pixels from 16 to 8192"
    try:
        width, height = checks.vector("picture size", size, 2)
        limits = {"low": 16, "high": 8192}
        return (
            checks.whole("picture size", width, **limits),
            checks.whole("picture size", height, **limits),
        )
    except InputError:
        checks.refuse("picture size", wanted, size)


def save_png(target: Path, image: Image) -> None:
    """Write a picture in one step."""
    try:
        with replacing(target) as path:
            imageio().imwrite(path, image, extension=".png")
    except OSError as error:
        cause = error.strerror or error
        raise OutputError(f"{str(target)!r} could not be written: {cause}") from error
