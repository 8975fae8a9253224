"""The ways in which a motion is run otherwise than shipped, its gains untouched."""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass, replace
from pathlib import Path
from unittest.mock import patch

from benchmarks.gains.cases import changed_character
from warp_softbody import scenes
from warp_softbody.characters import store
from warp_softbody.characters.store_mesh import RECIPES
from warp_softbody.scenes import ScenePlan

EDGES = 1.06
"""Edges of the other meshes over those of the shipped ones: TetGen fills a new surface."""

OTHER_EDGES = {"letter_x": 0.93}
"""Where that factor leaves dihedral angles below 9 degrees."""


@dataclass(frozen=True, kw_only=True)
class Variation:
    """Factors on a scene's own numbers, or another mesh."""

    name: str
    friction: float = 1.0
    stiffness: float = 1.0
    time_step: float = 1.0
    other_mesh: bool = False

    def plan(self, scene: str, meshes: Path) -> ScenePlan:
        """The scene so changed; the folder has the other meshes."""
        plan = scenes.make(scene)
        friction = {"friction": plan.settings["friction"] * self.friction}
        with _meshes_of(meshes if self.other_mesh else None):
            plan = scenes.make(scene, friction)
        character = plan.scene.character
        modulus = character.material.young_modulus * self.stiffness
        character = changed_character(character, "material.young_modulus", modulus)
        changed = replace(plan.scene, character=character)
        return replace(plan, scene=changed, time_step=plan.time_step * self.time_step)


VARIATIONS = {
    variation.name: variation
    for variation in (
        Variation(name="as shipped"),
        Variation(name="other mesh", other_mesh=True),
        Variation(name="friction -20 %", friction=0.8),
        Variation(name="friction +20 %", friction=1.2),
        Variation(name="stiffness -20 %", stiffness=0.8),
        Variation(name="stiffness +20 %", stiffness=1.2),
        Variation(name="half the step", time_step=0.5),
    )
}


def make_meshes(folder: Path, letters: Iterable[str] = tuple(RECIPES)) -> None:
    """Mesh the outlines of letters anew."""
    for name in letters:
        recipe = RECIPES[name]
        size = recipe.size * OTHER_EDGES.get(name, EDGES)
        store.save(*replace(recipe, size=size).make(), folder)


@contextmanager
def _meshes_of(folder: Path | None) -> Iterator[None]:
    """Characters that are made meanwhile get their meshes from a folder."""
    if folder is None:
        yield
        return
    with patch.object(store, "DATA", folder):
        yield
