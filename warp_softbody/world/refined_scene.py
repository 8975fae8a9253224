"""A scene on finer meshes: that of each body refined uniformly."""

from __future__ import annotations

from dataclasses import replace

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
        scene = replace(
            scene,
            character=refined_character(scene.character),
            others=tuple(
                replace(body, character=refined_character(body.character)) for body in scene.others
            ),
        )
    return scene
