"""Frames of a stage are drawn side by side in one picture, to show a motion at a glance."""

from __future__ import annotations

import math
import os
from collections.abc import Sequence
from pathlib import Path

import numpy as np

from warp_softbody.arrays import FloatArray
from warp_softbody.errors import InputError
from warp_softbody.inputs import checks
from warp_softbody.stage_exports.camera import Camera
from warp_softbody.stage_exports.conventions import checked_target
from warp_softbody.stage_exports.pictures.captions import captioned, measured, tick_step
from warp_softbody.stage_exports.pictures.floor import Floor
from warp_softbody.stage_exports.pictures.picture import Size, checked_size, save_png
from warp_softbody.stage_exports.pictures.render import Image, Renderer
from warp_softbody.stage_exports.pictures.ruler import FloorRuler
from warp_softbody.stage_exports.pictures.subject import Pose, Subject
from warp_softbody.stage_exports.usd.reader import Take, read_takes

_GAP = 4
_AIR, _ROD_AIR = 1.1, 0.15
"""How far a picture reaches beyond the bodies, and how much farther with a rod beside them."""


def draw_take(
    path: str | Path,
    take: Take | Sequence[Take] | str | Path,
    *,
    count: int = 12,
    columns: int = 4,
    size: Size = (360, 300),
    follow: bool = True,
    captions: bool = True,
    ruler: bool = True,
) -> Path:
    """Draw frames of a take at even intervals from first to last, row by row.

    Args:
        path: ends in .png; an existing file is replaced in one step.
        take: a take, the takes of several bodies, or the path of a stage, all of whose bodies are
            shown.
        count: frames drawn; fewer when the take has fewer.
        columns: frames in a row.
        size: width and height of one frame, pixels.
        follow: whether each frame shows the bodies in its middle, all from the same distance; else
            all frames share one camera, which sees the whole motion.
        captions: whether each frame tells its time and how far the bodies have come along the
            ground.
        ruler: whether a measuring rod lies on the ground along the way of the first body, with
            lengths in m from where its middle starts, if it goes anywhere.

    Returns:
        The path of the picture.
    """
    target = checked_target(path, extensions=(".png",))
    count = checks.whole("count of draw_take", count, low=1, high=10_000)
    columns = checks.whole("columns of draw_take", columns, low=1, high=10_000)
    size = checked_size(size)
    checks.truth("follow of draw_take", follow)
    checks.truth("captions of draw_take", captions)
    checks.truth("ruler of draw_take", ruler)
    shown = _takes(take)
    chosen = np.unique(np.linspace(0, len(shown[0]) - 1, count).round().astype(int)).tolist()
    cameras = _cameras(shown, chosen, size[0] / size[1], follow=follow, air=_AIR + ruler * _ROD_AIR)
    renderer = Renderer(Subject.of_takes(shown), cameras[0], size)
    if ruler and renderer.floor is not None:
        renderer.floor.ruler = _ruler(shown, chosen, renderer.floor, cameras[0])
    images = _drawn(renderer, shown, chosen, cameras)
    if captions:
        words = [told(shown, index) for index in chosen]
        images = [captioned(image, *own) for image, own in zip(images, words, strict=True)]
    save_png(target, _tiled(images, columns))
    return target


def _drawn(
    renderer: Renderer, takes: Sequence[Take], chosen: Sequence[int], cameras: Sequence[Camera]
) -> list[Image]:
    """The frames, with the lengths of a ruler at the same bands in all of them."""
    images, step = [], 1
    ruled = renderer.floor is not None and renderer.floor.ruler is not None
    for camera in cameras if ruled else ():
        renderer.look(camera)
        step = max(step, tick_step(renderer))
    for index, camera in zip(chosen, cameras, strict=True):
        renderer.look(camera)
        image = renderer.draw(Pose.of_takes(takes, index))
        images.append(measured(image, renderer, step) if ruled else image)
    return images


def _cameras(
    takes: Sequence[Take], chosen: Sequence[int], aspect: float, *, follow: bool, air: float
) -> list[Camera]:
    """One a frame."""
    if not follow:
        return [Camera.framing(*take_bounds(*takes), aspect=aspect, margin=1.2)] * len(chosen)
    boxes = [_box(takes, index) for index in chosen]
    aims = [(low + high) / 2.0 for low, high in boxes]
    away = max(
        Camera.distance(*box, aim=aim, aspect=aspect, margin=air)
        for box, aim in zip(boxes, aims, strict=True)
    )
    return [Camera.looking(aim, away) for aim in aims]


def _ruler(
    takes: Sequence[Take], chosen: Sequence[int], floor: Floor, camera: Camera
) -> FloorRuler | None:
    """A rod between the bodies' way and the camera."""
    first = takes[0]
    way = np.stack([first.tet_points[index].mean(axis=0) for index in (0, *chosen)])
    points = [take.skin_points[index] @ floor.axes.T for take in takes for index in chosen]
    towards = -camera.forward @ floor.axes.T
    return FloorRuler.beside(way @ floor.axes.T, np.concatenate(points), towards, floor.size)


def _box(takes: Sequence[Take], index: int) -> tuple[FloatArray, FloatArray]:
    points = np.concatenate([take.skin_points[index] for take in takes])
    return points.min(axis=0), points.max(axis=0)


def told(takes: Sequence[Take], index: int) -> tuple[str, str]:
    """Time of a frame, and the way of the first body's middle along the ground."""
    points = takes[0].tet_points
    normal = np.array((0.0, 0.0, 1.0) if takes[0].ground is None else takes[0].ground.normal)
    way = points[index].mean(axis=0) - points[0].mean(axis=0)
    gone = float(np.linalg.norm(way - (way @ normal) * normal))
    return f"{takes[0].times[index]:.2f} s", f"{gone:.2f} m"


def take_bounds(*takes: Take) -> tuple[FloatArray, FloatArray]:
    """Return the lowest and highest corner of all frames, as `Movie` takes them."""
    if not takes:
        raise InputError("take_bounds needs at least one take")
    checks.items("takes of take_bounds", takes, Take)
    low = [take.skin_points.min(axis=(0, 1)) for take in takes]
    high = [take.skin_points.max(axis=(0, 1)) for take in takes]
    return np.min(low, axis=0), np.max(high, axis=0)


def _takes(take: Take | Sequence[Take] | str | Path) -> tuple[Take, ...]:
    if isinstance(take, str | os.PathLike):
        return read_takes(take)
    takes = (take,) if isinstance(take, Take) else checks.items("take of draw_take", take, Take)
    if not takes or any(not np.array_equal(one.times, takes[0].times) for one in takes):
        raise InputError("a picture needs at least one take, and takes of the same frames")
    return takes


def _tiled(images: list[Image], columns: int) -> Image:
    """Pictures in rows with a thin white gap."""
    columns = min(columns, len(images))
    rows = math.ceil(len(images) / columns)
    height, width, _ = images[0].shape
    down, right = height + _GAP, width + _GAP
    sheet = np.full((rows * down - _GAP, columns * right - _GAP, 3), 255, dtype=np.uint8)
    for place, image in enumerate(images):
        row, column = divmod(place, columns)
        top, left = row * down, column * right
        sheet[top : top + height, left : left + width] = image
    return sheet
