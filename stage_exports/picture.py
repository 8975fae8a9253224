"""One frame as a PNG, drawn without a display."""

from __future__ import annotations

from pathlib import Path
from typing import Any

from warp_softbody.errors import InputError, MissingExtraError, OutputError
from warp_softbody.frame import Frame
from warp_softbody.replacing import replacing
from warp_softbody.scene import Scene
from warp_softbody.stage_exports.bodies import staged_bodies
from warp_softbody.stage_exports.camera import Camera, start_box
from warp_softbody.stage_exports.conventions import checked_target
from warp_softbody.stage_exports.render import Image, Renderer
from warp_softbody.stage_exports.subject import Pose, Subject

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
    target = checked_target(path, extensions=(".png",))
    bodies = staged_bodies(scene)
    camera = Camera.framing(*start_box(frame.positions), aspect=checked_aspect(size))
    renderer = Renderer(Subject.of_bodies(bodies, scene.ground), camera, size)
    save_png(target, renderer.draw(Pose.of_frame(frame, bodies)))
    return target


def checked_aspect(size: Size) -> float:
    """Width over height of a picture that can be drawn."""
    if len(size) != 2 or min(size) < 16 or max(size) > 8192:
        raise InputError(f"picture size must be two numbers from 16 to 8192, got {size!r}")
    return size[0] / size[1]


def save_png(target: Path, image: Image) -> None:
    """Write a picture in one step."""
    try:
        with replacing(target) as path:
            imageio().imwrite(path, image, extension=".png")
    except OSError as error:
        cause = error.strerror or error
        raise OutputError(f"{str(target)!r} could not be written: {cause}") from error


def imageio() -> Any:
    """The imageio package, or one sentence on where to get it."""
    try:
        import imageio.v2
    except ImportError as error:
        raise MissingExtraError(
            "pictures need imageio, which is not installed: pip install 'warp-softbody[view]'"
        ) from error
    return imageio.v2
