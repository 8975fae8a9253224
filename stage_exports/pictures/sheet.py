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
from warp_softbody.stage_exports.pictures.picture import Size, checked_size, save_png
from warp_softbody.stage_exports.pictures.render import Image, Renderer
from warp_softbody.stage_exports.pictures.subject import Pose, Subject
from warp_softbody.stage_exports.usd.reader import Take, read_takes

_GAP = 4


def draw_take(
    path: str | Path,
    take: Take | Sequence[Take] | str | Path,
    *,
    count: int = 12,
    columns: int = 4,
    size: Size = (360, 300),
) -> Path:
    """Draw frames of a take at even intervals from first to last, row by row.

    Args:
        path: ends in .png; an existing file is replaced in one step.
        take: a take, the takes of several bodies, or the path of a stage, all of whose bodies are
            shown.
        count: frames drawn; fewer when the take has fewer.
        columns: frames in a row.
        size: width and height of one frame, pixels.

    Returns:
        The path of the picture. All frames share one camera, which sees the whole motion.
    """
    target = checked_target(path, extensions=(".png",))
    count = checks.whole("count of draw_take", count, low=1, high=10_000)
    columns = checks.whole("columns of draw_take", columns, low=1, high=10_000)
    size = checked_size(size)
    shown = _takes(take)
    camera = Camera.framing(*take_bounds(*shown), aspect=size[0] / size[1], margin=1.2)
    renderer = Renderer(Subject.of_takes(shown), camera, size)
    chosen = np.unique(np.linspace(0, len(shown[0]) - 1, count).round().astype(int))
    images = [renderer.draw(Pose.of_takes(shown, index)) for index in chosen.tolist()]
    save_png(target, _tiled(images, columns))
    return target


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
