"""Run by the Python that has bpy: frames of a stage drawn by Cycles, and what it has read.

Arguments: the stage, a folder for the pictures, and frames.
"""

from __future__ import annotations

import json
import sys
from typing import Any

import bpy


def main(stage: str, folder: str, frames: list[int]) -> None:
    """Draw the frames and print how far normals are from the faces' at the last one."""
    bpy.ops.wm.read_factory_settings(use_empty=True)
    bpy.ops.wm.usd_import(filepath=stage, import_guide=False)
    scene = bpy.context.scene
    scene.camera = next(one for one in bpy.data.objects if one.type == "CAMERA")
    scene.render.engine = "CYCLES"
    scene.cycles.device = "CPU"
    scene.cycles.samples = 12
    scene.render.resolution_x, scene.render.resolution_y = 320, 240
    for frame in frames:
        scene.frame_set(frame)
        scene.render.filepath = f"{folder}/{frame:04d}.png"
        bpy.ops.render.render(write_still=True)
    skins = [one for one in bpy.data.objects if one.type == "MESH" and one.name.startswith("Skin")]
    curves = [one for one in bpy.data.objects if one.type in ("CURVE", "CURVES")]
    print("\n" + json.dumps({"bent": max(map(bent, skins)), "curves": len(curves)}))


def bent(skin: Any) -> float:
    """Largest angle, radians, between the normal at a corner and that of its face."""
    graph = bpy.context.evaluated_depsgraph_get()
    mesh = skin.evaluated_get(graph).to_mesh()
    angles = [
        mesh.corner_normals[corner].vector.angle(face.normal)
        for face in mesh.polygons
        for corner in face.loop_indices
    ]
    return float(max(angles))


if __name__ == "__main__":
    main(sys.argv[1], sys.argv[2], [int(word) for word in sys.argv[3:]])
