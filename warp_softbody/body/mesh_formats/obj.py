"""A Wavefront OBJ file is read for its points and faces; no material file is opened."""

from __future__ import annotations

from pathlib import Path

from warp_softbody.body.mesh_formats.polygons import Polygons

LEFT_OUT = frozenset(
    "vt vn vp g o s l p usemtl mtllib usemap maplib shadow_obj trace_obj bevel c_interp "
    "d_interp lod mg".split()
)
"""Keywords that say nothing of the shape of the surface."""


def read_obj(path: Path) -> Polygons:
    """Points and polygons, which may count points back from the last one."""
    text = path.read_bytes().decode("utf-8", errors="replace").replace("\\\n", " ")
    points: list[tuple[float, float, float]] = []
    faces: list[list[int]] = []
    for number, line in enumerate(text.splitlines(), 1):
        words = line.partition("#")[0].split()
        if not words:
            continue
        if words[0] == "v":
            if len(words) not in (4, 5, 7, 8):
                raise ValueError(f"the point of line {number} has {len(words) - 1} numbers")
            points.append((float(words[1]), float(words[2]), float(words[3])))
        elif words[0] == "f":
            faces.append([_index(word, len(points), number) for word in words[1:]])
        elif words[0] not in LEFT_OUT:
            raise ValueError(f"line {number} begins with {words[0]!r}, which is not known")
    return Polygons(points, faces)


def _index(word: str, count: int, line: int) -> int:
    """Index from 0 of a corner such as 3, 3/1, 3//2, 3/1/2 or -1."""
    parts = word.split("/")
    if len(parts) > 3:
        raise ValueError(f"line {line} has the corner {word!r}")
    for part in parts[1:]:
        if part:
            int(part)
    index = int(parts[0])
    if index == 0:
        raise ValueError(f"line {line} has point 0, but points are counted from 1")
    return index - 1 if index > 0 else count + index
