"""The chunks of a take are merged into one layer; this may run in a process of its own."""

from __future__ import annotations

import os
import time
from collections.abc import Mapping
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any

from pxr import Sdf, Tf

from warp_softbody.errors import InputError
from warp_softbody.stage_exports.usd import watchdog
from warp_softbody.stage_exports.usd.textures import keep_textures, kept_textures, textures_of

STATIC = "static.usdc"
PACKED = ".usdz"
CRATES = (".usdc", ".usd")
GROWING = "growing.usdc"
GROUP_BYTES = 256 << 20
"""Of chunks that are merged at once: what a long take needs of memory is about twice that."""


def closed_chunks(folder: Path) -> list[Path]:
    """The chunks of a folder in the order of their frames."""
    return sorted(folder.glob("frames_*.usdc"))


def merge(folder: str, target: str, group_bytes: int = GROUP_BYTES) -> int:
    """Write what does not move and all chunks of a folder as one stage.

    Args:
        folder: of the chunks.
        target: a file that may be half-written when this fails.
        group_bytes: of chunks that are held in memory at once.

    Returns:
        The number of frames.

    Raises:
        InputError: a chunk is missing or damaged.
        OSError: the stage could not be written.
    """
    home = Path(folder)
    groups = _groups(closed_chunks(home), group_bytes)
    if len(groups) > 1:
        return _merged_on_disk(home, groups, target)
    merged = Sdf.Layer.CreateAnonymous(".usda")
    _begin(merged, home, groups)
    _stitch(merged, groups[0])
    export(merged, target, kept_textures(home))
    return len(merged.ListAllTimeSamples())


def _merged_on_disk(home: Path, groups: list[list[Path]], target: str) -> int:
    """Let a file grow by one group of chunks after another, so that one group is held at a time.

    Each saving leaves some of what stood in the file unused, so groups are large.
    """
    # not in their folder, which may be on another disk
    growing = Path(target).with_name(GROWING)
    merged = Sdf.Layer.CreateNew(str(growing))
    if merged is None:
        raise OSError("USD could not begin the layer")
    _begin(merged, home, groups)
    for group in groups:
        _stitch(merged, group)
        if not merged.Save():
            raise OSError("USD could not save the layer")
    frames = len(merged.ListAllTimeSamples())
    path = Path(target)
    if path.suffix.lower() in CRATES:
        growing.replace(path)
    elif path.suffix.lower() == PACKED:
        _pack(growing.replace(path.with_name(f"{path.stem}.usdc")), path, kept_textures(home))
    else:
        export(merged, target)
        growing.unlink()
    return frames


def _groups(chunks: list[Path], group_bytes: int) -> list[list[Path]]:
    """Consecutive chunks of at most so many bytes together, or one larger chunk."""
    groups: list[list[Path]] = [[]]
    held = 0
    for chunk in chunks:
        size = chunk.stat().st_size
        if groups[-1] and held + size > group_bytes:
            groups.append([])
            held = 0
        groups[-1].append(chunk)
        held += size
    return groups


def _begin(merged: Any, home: Path, groups: list[list[Path]]) -> None:
    """What does not move, and the time codes of the first and last frame."""
    merged.TransferContent(opened(home / STATIC))
    merged.startTimeCode = opened(groups[0][0]).startTimeCode
    merged.endTimeCode = opened(groups[-1][-1]).endTimeCode


def _stitch(merged: Any, group: list[Path]) -> None:
    # loading it takes longer than most stages, which are not merged at all
    from pxr import UsdUtils

    # all stay open until the layer is written, as it takes their arrays without copying them
    layers = [opened(chunk) for chunk in group]
    for layer in layers:
        watchdog.feed()
        UsdUtils.StitchLayers(merged, layer)
    watchdog.feed()


def rewrite(source: str, target: str) -> dict[str, bytes]:
    """The task of the process that reads the stage.

    Returns:
        Textures by their paths from the stage, which the new file does not hold.

    Raises:
        InputError: the source is no USD file.
        OSError: the target could not be written.
    """
    layer = Sdf.Layer.OpenAsAnonymous(source)
    if layer is None:
        raise InputError(f"{source!r} is not a USD file that can be read")
    textures = textures_of(layer, source)
    export(layer, target, textures)
    return {} if target.lower().endswith(PACKED) else textures


def export(layer: Any, target: str, textures: Mapping[str, bytes] | None = None) -> None:
    """Write a layer, into an archive with its textures; it may be half-written when this fails.

    Raises:
        OSError: it could not be written.
    """
    path = Path(target)
    packed = path.suffix.lower() == PACKED
    inner = path.with_name(f"{path.stem}.usdc") if packed else path
    try:
        if not layer.Export(str(inner)):
            raise OSError("USD could not export the layer")
        if packed:
            _pack(inner, path, textures or {})
    except Tf.ErrorException as error:
        raise OSError(reason(error)) from error


def _pack(inner: Path, target: Path, textures: Mapping[str, bytes]) -> None:
    """Put a layer and its textures into an uncompressed archive of the kind that .usdz is.

    It tells when its files were written; all are given one time, so that the archive of the same
    files is the same.
    """
    archive = Sdf.ZipFileWriter.CreateNew(str(target))
    _date(inner)
    added = [archive.AddFile(str(inner), inner.name)]
    with TemporaryDirectory(dir=target.parent) as folder:
        keep_textures(Path(folder), textures)
        for name in textures:
            _date(Path(folder) / name)
            added.append(archive.AddFile(str(Path(folder) / name), name))
    archive.Save()
    inner.unlink()
    if not all(added):
        raise OSError("USD could not pack the layer")


def _date(path: Path) -> None:
    """Let a file seem to be of the first hour, here, that an archive can tell."""
    first = time.mktime((1980, 1, 1, 0, 0, 0, 0, 1, -1))
    os.utime(path, (first, first))


def reason(error: BaseException) -> str:
    """The cause alone: USD appends every error that followed from it."""
    if isinstance(error, Tf.ErrorException) and error.args:
        return str(error.args[0].commentary)
    if isinstance(error, OSError) and error.strerror:
        return error.strerror
    return str(error)


def opened(path: Path) -> Any:
    """A layer read anew: OpenAsAnonymous never hands out what an older file of that name held.

    Raises:
        InputError: there is none.
    """
    layer = Sdf.Layer.OpenAsAnonymous(str(path)) if path.is_file() else None
    if layer is None:
        raise InputError(f"{path.name} is missing or damaged")
    return layer
