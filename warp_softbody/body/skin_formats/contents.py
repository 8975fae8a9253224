"""What readers of skins return, unchecked."""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np
import numpy.typing as npt


class SkinContents(NamedTuple):
    """A surface out of a file.

    Attributes:
        points: (k, 3) m.
        faces: (f, 3) of them.
        texture_points: (t, 2), u to the right and v upwards in the picture; none is (0, 2).
        texture_faces: (f, 3) of them; (0, 3) where there are none.
        materials: fields of `SkinMaterial` by name.
        face_materials: (f,) which of them.
        notes: sentences on what was left out.
    """

    points: npt.NDArray[np.float64]
    faces: npt.NDArray[np.int64]
    texture_points: npt.NDArray[np.float64]
    texture_faces: npt.NDArray[np.int64]
    materials: list[dict[str, Any]]
    face_materials: npt.NDArray[np.int64]
    notes: tuple[str, ...] = ()


NO_TEXTURE = (np.zeros((0, 2)), np.zeros((0, 3), dtype=np.int64))


def welded(contents: SkinContents) -> SkinContents:
    """Points at one place joined, as files cut a surface where they cut its texture."""
    _, first, number = np.unique(contents.points, axis=0, return_index=True, return_inverse=True)
    # in the order of the file
    order = np.argsort(first, kind="stable")
    place = np.empty(len(first), dtype=np.int64)
    place[order] = np.arange(len(first))
    faces = place[number.reshape(-1)][contents.faces]
    whole = (faces != np.roll(faces, 1, axis=1)).all(axis=1)
    notes = contents.notes
    if not whole.all():
        notes = (*notes, f"{(~whole).sum()} triangles without an area were left out")
    textured = len(contents.texture_faces) > 0
    return contents._replace(
        points=contents.points[first[order]],
        faces=faces[whole],
        texture_faces=contents.texture_faces[whole] if textured else contents.texture_faces,
        face_materials=contents.face_materials[whole],
        notes=notes,
    )
