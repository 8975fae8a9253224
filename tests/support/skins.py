"""A textured box as files of several kinds, and a picture of four colours."""

from __future__ import annotations

import io
from pathlib import Path

import numpy as np
from PIL import Image

import warp_softbody as wsb
from warp_softbody.arrays import FloatArray

COLORS = np.array([[255, 0, 0], [0, 255, 0], [0, 0, 255], [255, 255, 0]], dtype=np.uint8)
"""Of the quarters of the picture: upper left and right, lower left and right."""

FACES = [(0, 1, 3, 2), (4, 6, 7, 5), (0, 4, 5, 1), (2, 3, 7, 6), (0, 2, 6, 4), (1, 5, 7, 3)]
"""Outward quadrilaterals over the corners of a box, in the order of `corners`."""


def corners(size: tuple[float, float, float]) -> FloatArray:
    """(8, 3) m of a box from the origin, z fastest."""
    return np.array([[x, y, z] for x in (0, size[0]) for y in (0, size[1]) for z in (0, size[2])])


def picture() -> bytes:
    """A PNG of 8 x 8 pixels."""
    image = np.repeat(np.repeat(COLORS.reshape(2, 2, 3), 4, axis=0), 4, axis=1)
    stream = io.BytesIO()
    Image.fromarray(image).save(stream, format="PNG")
    return stream.getvalue()


def box_skin(size: tuple[float, float, float]) -> wsb.Skin:
    """The box, each side showing the whole picture; its sides at the end of z are plain blue."""
    triangles = [(a, b, c) for q in FACES for a, b, c in ((q[0], q[1], q[2]), (q[0], q[2], q[3]))]
    return wsb.Skin(
        points=corners(size),
        faces=np.array(triangles, dtype=np.int32),
        texture_points=np.array([(0.0, 0.0), (1.0, 0.0), (1.0, 1.0), (0.0, 1.0)]),
        texture_faces=np.tile(np.array([(0, 1, 2), (0, 2, 3)], dtype=np.int32), (6, 1)),
        materials=(
            wsb.SkinMaterial(name="sides", color=(1.0, 1.0, 1.0), texture=picture()),
            wsb.SkinMaterial(name="ends", color=(0.0, 0.0, 1.0), roughness=0.9),
        ),
        face_materials=np.repeat([0, 0, 0, 0, 1, 1], 2).astype(np.int32),
    )


def write_obj(folder: Path, size: tuple[float, float, float]) -> Path:
    """The same as an .obj with its .mtl and .png, in quadrilaterals."""
    (folder / "box.png").write_bytes(picture())
    (folder / "box.mtl").write_text(
        "newmtl sides\nKd 1 1 1\nmap_Kd box.png\nnewmtl ends\nKd 0 0 1\nPr 0.9\n"
    )
    lines = ["mtllib box.mtl", *("v {:g} {:g} {:g}".format(*p) for p in corners(size))]
    lines += ["vt 0 0", "vt 1 0", "vt 1 1", "vt 0 1"]
    for number, quad in enumerate(FACES):
        lines.append("usemtl sides" if number < 4 else "usemtl ends")
        lines.append("f " + " ".join(f"{p + 1}/{k + 1}" for k, p in enumerate(quad)))
    (folder / "box.obj").write_text("\n".join(lines) + "\n")
    return folder / "box.obj"
