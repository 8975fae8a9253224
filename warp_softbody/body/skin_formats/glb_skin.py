"""A binary glTF by trimesh: all its meshes in their places, y turned to z."""

from __future__ import annotations

import io
from pathlib import Path
from typing import Any

import numpy as np

from warp_softbody.body.skin_formats.contents import NO_TEXTURE, SkinContents


def read_glb_skin(path: Path) -> SkinContents:
    """Points, triangles, texture coordinates and base colours.

    Raises:
        ValueError, OSError: it is none, or cannot be read.
    """
    import trimesh

    with path.open("rb") as stream:
        try:
            scene = trimesh.load_scene(stream, file_type="glb", process=False)
        except Exception as error:
            # whatever a library says of a damaged file
            raise ValueError(" ".join(str(error).split())[:200] or "it is none") from error
    parts: list[Any] = [geometry for geometry in scene.dump() if hasattr(geometry, "faces")]
    if not parts:
        raise ValueError("it holds no triangles")
    counts = np.cumsum([0, *(len(part.vertices) for part in parts)])
    points = np.concatenate([np.asarray(part.vertices, dtype=np.float64) for part in parts])
    faces = [np.asarray(p.faces, dtype=np.int64) + n for p, n in zip(parts, counts, strict=False)]
    places = [_texture_points(part) for part in parts]
    every = np.concatenate(faces)
    texture = NO_TEXTURE
    if all(place is not None for place in places):
        texture = np.concatenate([place for place in places if place is not None]), every
    return SkinContents(
        # glTF has y upwards
        np.stack([points[:, 0], -points[:, 2], points[:, 1]], axis=1),
        every,
        *texture,
        [_material(part, number) for number, part in enumerate(parts)],
        np.repeat(np.arange(len(parts)), [len(part.faces) for part in parts]),
    )


def _texture_points(part: Any) -> Any:
    """V upwards, as trimesh keeps it."""
    places = getattr(part.visual, "uv", None)
    return None if places is None else np.asarray(places, dtype=np.float64)


def _material(part: Any, number: int) -> dict[str, Any]:
    given = getattr(part.visual, "material", None)
    found: dict[str, Any] = {"name": str(getattr(given, "name", None) or f"material_{number}")}
    factor = getattr(given, "baseColorFactor", None)
    if factor is not None:
        values = np.asarray(factor, dtype=np.float64).reshape(-1)
        values = values / 255.0 if np.asarray(factor).dtype.kind in "iu" else values
        found["color"] = tuple(np.clip(values[:3], 0.0, 1.0).tolist())
        found["opacity"] = float(np.clip(values[3], 0.0, 1.0)) if len(values) > 3 else 1.0
    roughness = getattr(given, "roughnessFactor", None)
    if roughness is not None:
        found["roughness"] = float(np.clip(roughness, 0.0, 1.0))
    picture = getattr(given, "baseColorTexture", None)
    if picture is not None:
        stream = io.BytesIO()
        picture.save(stream, format="PNG")
        found["texture"] = stream.getvalue()
    return found
