"""A Wavefront OBJ with texture coordinates, and the materials and pictures that it names."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np

from warp_softbody.body.skin_formats.contents import NO_TEXTURE, SkinContents

DEFAULT = "default"
LARGEST_PICTURE = 64 << 20
"""Bytes of a texture's file."""


class _Reading:
    """The state of a file that is being read."""

    def __init__(self, folder: Path) -> None:
        self.folder = folder
        self.points: list[tuple[float, ...]] = []
        self.texture: list[tuple[float, ...]] = []
        self.faces: list[tuple[int, ...]] = []
        self.texture_faces: list[tuple[int, ...]] = []
        self.face_materials: list[int] = []
        self.names: dict[str, int] = {}
        self.known: dict[str, dict[str, Any]] = {}
        self.notes: list[str] = []
        self.current = DEFAULT

    def face(self, words: list[str], number: int) -> None:
        """A polygon, cut from its first corner."""
        corners = [_corner(word, len(self.points), len(self.texture), number) for word in words]
        if len(corners) < 3:
            raise ValueError(f"the face of line {number} has {len(corners)} corners")
        material = self.names.setdefault(self.current, len(self.names))
        for k in range(1, len(corners) - 1):
            chosen = (corners[0], corners[k], corners[k + 1])
            self.faces.append(tuple(point for point, _ in chosen))
            self.texture_faces.append(tuple(place for _, place in chosen))
            self.face_materials.append(material)


def read_obj_skin(path: Path) -> SkinContents:
    """Points, triangles, texture coordinates and materials.

    Raises:
        ValueError, OSError: it is none, or cannot be read.
    """
    read = _Reading(path.parent)
    text = path.read_bytes().decode("utf-8", errors="replace").replace("\\\n", " ")
    for number, line in enumerate(text.splitlines(), 1):
        words = line.partition("#")[0].split()
        if not words:
            continue
        if words[0] == "v" and len(words) >= 4:
            read.points.append(tuple(map(float, words[1:4])))
        elif words[0] == "vt" and len(words) >= 2:
            read.texture.append((float(words[1]), float(words[2]) if len(words) > 2 else 0.0))
        elif words[0] == "f":
            read.face(words[1:], number)
        elif words[0] == "usemtl":
            read.current = " ".join(words[1:]) or DEFAULT
        elif words[0] == "mtllib":
            _read_materials(read, " ".join(words[1:]))
    return _contents(read)


def _contents(read: _Reading) -> SkinContents:
    places = np.array(read.texture_faces, dtype=np.int64).reshape(-1, 3)
    texture = np.array(read.texture, dtype=np.float64).reshape(-1, 2), places
    if not len(places) or (places < 0).any():
        if read.texture:
            read.notes.append("not every corner has a texture coordinate, so that none is taken")
        texture = NO_TEXTURE
    for name in read.names:
        if name != DEFAULT and name not in read.known:
            read.notes.append(f"material {name!r} is not in its files")
    return SkinContents(
        np.array(read.points, dtype=np.float64).reshape(-1, 3),
        np.array(read.faces, dtype=np.int64).reshape(-1, 3),
        *texture,
        [{"name": name, **read.known.get(name, {})} for name in read.names],
        np.array(read.face_materials, dtype=np.int64),
        tuple(read.notes),
    )


def _corner(word: str, points: int, texture: int, line: int) -> tuple[int, int]:
    """Point and texture coordinate, from 0, of a corner such as 3, 3/1, 3//2 or -1/-1."""
    parts = word.split("/")
    place = -1
    if len(parts) > 1 and parts[1]:
        place = _index(parts[1], texture, "texture coordinate", line)
    return _index(parts[0], points, "point", line), place


def _index(text: str, count: int, what: str, line: int) -> int:
    given = int(text)
    index = given - 1 if given > 0 else count + given
    if given == 0 or not 0 <= index < count:
        raise ValueError(f"line {line} has {what} {given} of {count}")
    return index


def _read_materials(read: _Reading, name: str) -> None:
    """Add the materials of a file beside the surface; what is missing is noted."""
    try:
        text = (read.folder / name).read_bytes().decode("utf-8", errors="replace")
    except (OSError, ValueError):
        read.notes.append(f"the file of materials {name!r} cannot be read")
        return
    own: dict[str, Any] = {}
    for line in text.splitlines():
        words = line.partition("#")[0].split()
        if len(words) < 2:
            continue
        if words[0] == "newmtl":
            own = read.known.setdefault(" ".join(words[1:]), {})
        elif words[0] == "Kd" and len(words) >= 4:
            own["color"] = tuple(min(1.0, max(0.0, float(word))) for word in words[1:4])
        elif words[0] == "d":
            own["opacity"] = min(1.0, max(0.0, float(words[-1])))
        elif words[0] == "Pr":
            own["roughness"] = min(1.0, max(0.0, float(words[1])))
        elif words[0] == "map_Kd":
            _read_picture(read, own, line.split(None, 1)[1].strip())


def _read_picture(read: _Reading, own: dict[str, Any], words: str) -> None:
    """The bytes of a picture; options of its placement come before its name."""
    names = [words, words.split()[-1]]
    for name in names:
        path = read.folder / name.replace("\\", "/")
        if path.is_file():
            if path.stat().st_size > LARGEST_PICTURE:
                raise ValueError(f"its texture {name!r} is larger than {LARGEST_PICTURE} bytes")
            own["texture"] = path.read_bytes()
            return
    read.notes.append(f"the texture {names[-1]!r} cannot be read")
