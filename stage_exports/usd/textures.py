"""Textures lie in a folder beside their stage, or in the archive that it is."""

from __future__ import annotations

import zipfile
from collections.abc import Mapping
from pathlib import Path
from typing import Any

from pxr import Sdf

from warp_softbody.atomic_files import replacing

FOLDER = "{}_textures"
"""Beside the stage of that name."""

LARGEST = 64 << 20
"""Bytes of a texture."""


def keep_textures(folder: Path, files: Mapping[str, bytes]) -> None:
    """Write files by their paths within a folder, each in one step.

    Raises:
        OSError: one could not be written.
    """
    for name, data in files.items():
        path = folder / name
        path.parent.mkdir(exist_ok=True)
        with replacing(path) as beside:
            beside.write_bytes(data)


def kept_textures(folder: Path) -> dict[str, bytes]:
    """All files of folders within a folder, by their paths in it."""
    found = sorted(path for path in folder.glob("*/*") if path.is_file())
    return {path.relative_to(folder).as_posix(): path.read_bytes() for path in found}


def textures_of(layer: Any, source: str) -> dict[str, bytes]:
    """Files that a layer names and that lie where they should, by their paths in its folder."""
    found = named_textures(layer, source)
    return {_within(name): data for name, data in found.items() if data}


def named_textures(layer: Any, source: str) -> dict[str, bytes]:
    """All files that a layer names; no bytes for one that is not where it should."""
    names: list[str] = []

    def visit(path: Any) -> None:
        attribute = layer.GetAttributeAtPath(path)
        if attribute is not None and attribute.typeName == Sdf.ValueTypeNames.Asset:
            names.append(str(attribute.default.path) if attribute.default else "")

    layer.Traverse(Sdf.Path.absoluteRootPath, visit)
    return {name: texture(source, name) for name in dict.fromkeys(names)}


def texture(source: str, asset: str) -> bytes:
    """The bytes of a file that a stage names; none where it is not within the stage's folder."""
    name = _within(asset)
    if not name:
        return b""
    try:
        if source.lower().endswith(".usdz"):
            with zipfile.ZipFile(source) as archive:
                entry = archive.getinfo(name)
                return archive.read(entry) if entry.file_size <= LARGEST else b""
        path = Path(source).parent / name
        return path.read_bytes() if path.stat().st_size <= LARGEST else b""
    except (OSError, KeyError, ValueError, zipfile.BadZipFile):
        return b""


def _within(asset: str) -> str:
    """A path without a way out of its folder; empty where it has one."""
    name = asset.removeprefix("./")
    parts = name.split("/")
    outside = name.startswith("/") or ".." in parts or ":" in parts[0] or "\\" in name
    return "" if outside or not all(parts) else name
