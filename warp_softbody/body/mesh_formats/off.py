"""An OFF file has its counts, then a line for each point and a line for each face."""

from __future__ import annotations

from pathlib import Path

from warp_softbody.body.mesh_formats.polygons import Polygons, word_lines

PREFIXES = ("OFF", "COFF", "NOFF", "CNOFF", "STOFF")


def read_off(path: Path) -> Polygons:
    """Points and polygons; normals and colours are left out."""
    lines = word_lines(path.read_bytes())
    if not lines or lines[0][0].upper() not in PREFIXES:
        raise ValueError("its first word is not OFF")
    if lines[0][1:2] and lines[0][1].upper() == "BINARY":
        raise ValueError("a binary OFF is not taken")
    counts = lines[0][1:] or lines[1]
    start = 1 if lines[0][1:] else 2
    point_count, face_count = int(counts[0]), int(counts[1])
    found = len(lines) - start
    if point_count < 0 or face_count < 0 or found != point_count + face_count:
        raise ValueError(
            f"it declares {point_count} points and {face_count} faces, "
            f"but has {found} lines for them"
        )
    points = [_point(words) for words in lines[start : start + point_count]]
    return Polygons(points, [_face(words) for words in lines[start + point_count :]])


def _point(words: list[str]) -> tuple[float, float, float]:
    if len(words) < 3:
        raise ValueError(f"the point {' '.join(words)!r} has {len(words)} numbers")
    return float(words[0]), float(words[1]), float(words[2])


def _face(words: list[str]) -> list[int]:
    count = int(words[0])
    if count < 3 or len(words) <= count:
        raise ValueError(f"the face {' '.join(words)[:60]!r} has not {max(count, 3)} corners")
    return [int(word) for word in words[1 : count + 1]]
