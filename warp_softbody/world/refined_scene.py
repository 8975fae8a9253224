"""A scene on finer meshes: that of each body refined uniformly."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from warp_softbody.arrays import FloatArray
from warp_softbody.body.character import Character
from warp_softbody.body.mesh_refinement import refine
from warp_softbody.body.refinement import refined_character
from warp_softbody.errors import InputError
from warp_softbody.world.scene import Scene


def refined_scene(scene: Scene, levels: int) -> Scene:
    """The scene with every tet of all its bodies cut into eight, ``levels`` times over.

    Raises:
        InputError: ``levels`` is negative.
    """
    if levels < 0:
        raise InputError(f"a mesh can be refined 0 or more times, got {levels}")
    for _ in range(levels):
        others = tuple(
            replace(
                body,
                character=refined_character(body.character),
                pose=_refined_pose(body.character, body.pose),
            )
            for body in scene.others
        )
        scene = replace(
            scene,
            character=refined_character(scene.character),
            initial_pose=_refined_pose(scene.character, scene.initial_pose),
            others=others,
        )
    return scene


def _refined_pose(character: Character, pose: FloatArray | None) -> FloatArray | None:
    """Places of the nodes of a refined mesh: new ones are in the middles of their edges."""
    if pose is None:
        return None
    _, edges = refine(character.mesh)
    return np.concatenate([pose, pose[edges].mean(axis=1)])
