"""A frame of a stage as one picture: from where, how large, and with what of it."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path

import numpy as np
import numpy.typing as npt

from warp_softbody.errors import InputError
from warp_softbody.inputs import checks
from warp_softbody.stage_exports.camera import Camera
from warp_softbody.stage_exports.camera_paths import FOLLOW, CameraChoice, camera_path
from warp_softbody.stage_exports.conventions import checked_target
from warp_softbody.stage_exports.pictures.captions import captioned
from warp_softbody.stage_exports.pictures.picture import DEFAULT_SIZE, Size, checked_size, save_png
from warp_softbody.stage_exports.pictures.render import Image, Renderer, tone
from warp_softbody.stage_exports.pictures.sheet import told
from warp_softbody.stage_exports.pictures.subject import Pose, Subject
from warp_softbody.stage_exports.usd.reader import Take, read_takes

LAYERS = ("skin", "muscles", "ground")


def draw_frame(
    path: str | Path,
    stage: str | Path,
    *,
    frame: int | None = None,
    time: float | None = None,
    size: Size = DEFAULT_SIZE,
    camera: CameraChoice = FOLLOW,
    layers: Sequence[str] = LAYERS,
    transparent: bool = False,
    caption: bool = False,
) -> Path:
    """Draw a frame of a finished stage; returns the path of the picture.

    Args:
        path: ends in .png; an existing file is replaced in one step.
        stage: that a `StageWriter` wrote.
        frame: its number from 0; counted from the last one where it is negative. By default the
            last one.
        time: s, instead of a number; the frame nearest to it is drawn.
        size: width and height, pixels.
        camera: as for a `StageWriter`.
        layers: which of "skin", "muscles" and "ground" are drawn.
        transparent: leave the background out; there is no ground then.
        caption: tell the time, and how far the first body has come along the ground.

    Raises:
        InputError: a value is none of these, or the stage is none.
        OutputError: the path cannot be written.
    """
    target = checked_target(path, extensions=(".png",))
    size = checked_size(size)
    layers = _checked_layers(layers)
    checks.truth("transparent of draw_frame", transparent)
    checks.truth("caption of draw_frame", caption)
    if frame is not None:
        frame = _checked_frame(frame)
    if time is not None:
        time = checks.number("time of draw_frame", time, unit="s")
    takes = read_takes(stage)
    index = _index(takes[0], frame, time)
    view = _view(takes, index, camera, size[0] / size[1])
    renderer = Renderer(_subject(takes, layers, transparent=transparent), view, size)
    pose = Pose.of_takes(takes, index)
    if "muscles" not in layers:
        pose = replace(pose, segments=pose.segments[:0], activations=pose.activations[:0])
    image = _cut_out(renderer, pose) if transparent else renderer.draw(pose)
    save_png(target, captioned(image, *told(takes, index)) if caption else image)
    return target


def _checked_layers(layers: object) -> tuple[str, ...]:
    if isinstance(layers, str):
        checks.refuse("layers of draw_frame", "a sequence of names", layers)
    given = checks.several("layers of draw_frame", layers, "a sequence of names")
    found = tuple(checks.choice("a layer of draw_frame", one, LAYERS) for one in given)
    if not set(found) & {"skin", "muscles"}:
        raise InputError('layers of draw_frame must hold "skin" or "muscles"')
    return found


def _checked_frame(frame: object) -> int:
    given = checks.plain(frame)
    if isinstance(given, int) and not isinstance(given, bool) and given < 0:
        return -checks.whole("frame of draw_frame, from the last one", -given, low=1)
    return checks.whole("frame of draw_frame", frame)


def _index(take: Take, frame: int | None, time: float | None) -> int:
    """The place of the frame that is meant."""
    if frame is not None and time is not None:
        raise InputError("draw_frame takes a frame or a time, not both")
    if time is not None:
        return int(np.argmin(np.abs(take.times - time)))
    wanted = -1 if frame is None else frame
    if not -len(take) <= wanted < len(take):
        raise InputError(
            f"frame of draw_frame must be from 0 to {len(take) - 1}, the frames of the stage, "
            f"got {wanted}"
        )
    return wanted % len(take)


def _view(takes: Sequence[Take], index: int, camera: CameraChoice, aspect: float) -> Camera:
    """Where the camera of a movie is at that frame."""
    start = np.concatenate([take.tet_points[0] for take in takes])
    path = camera_path("camera of draw_frame", camera, start, aspect)
    view = path.at(takes[0].times[0], start)
    for number in range(1, index + 1) if path.moves else ():
        points = np.concatenate([take.tet_points[number] for take in takes])
        view = path.at(takes[0].times[number], points)
    return view


def _subject(takes: Sequence[Take], layers: Sequence[str], *, transparent: bool) -> Subject:
    subject = Subject.of_takes(takes)
    if transparent or "ground" not in layers:
        subject = replace(subject, ground=None)
    if "muscles" not in layers:
        subject = replace(subject, segment_bodies=subject.segment_bodies[:0])
    if "skin" not in layers:
        none = tuple(None for _ in subject.skins)
        subject = replace(
            subject, faces=subject.faces[:0], face_bodies=subject.face_bodies[:0], skins=none
        )
    return subject


def _cut_out(renderer: Renderer, pose: Pose) -> Image:
    """(h, w, 4): what differs between a black and a white background is the background."""
    black, white = (
        renderer.draw(pose, background=np.full(3, level)).astype(np.float64) for level in (0.0, 1.0)
    )
    bright = np.floor(255.0 * float(tone(np.ones(1))[0]) + 0.5)
    through = np.clip((white - black).max(axis=2) / bright, 0.0, 1.0)
    alpha = 1.0 - through
    color = np.divide(black, alpha[..., None], out=np.zeros_like(black), where=alpha[..., None] > 0)
    layers: npt.NDArray[np.float64] = np.concatenate([color, 255.0 * alpha[..., None]], axis=2)
    return np.rint(np.clip(layers, 0.0, 255.0)).astype(np.uint8)
