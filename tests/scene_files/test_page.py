"""The page on scene files names every key that there is."""

from __future__ import annotations

import re
from dataclasses import fields
from pathlib import Path
from typing import Any

import pytest

from tests.docs.pages import ROOT
from warp_softbody import (
    DragField,
    FrictionMap,
    HeightField,
    Material,
    MotionPath,
    Plane,
    Push,
    RadialField,
    TriangleGround,
    UniformField,
    scene_files,
)
from warp_softbody.characters import letter_i
from warp_softbody.scene_files.bodies import FRICTION, OWN, PLACE, START
from warp_softbody.scene_files.motions import COMPOSED, ENDS, KINDS
from warp_softbody.scene_files.reading import KEYS, WORLD
from warp_softbody.scene_files.scene_file import RunOutput
from warp_softbody.scene_files.shapes import OF_SURFACE, SHAPES

PAGE = (ROOT / "docs" / "scene-files.md").read_text(encoding="utf-8")
FIELD_KINDS = (UniformField, RadialField, DragField)
RECORDS = (
    *(Plane, HeightField, TriangleGround, FrictionMap, Material, Push, MotionPath, RunOutput),
    *FIELD_KINDS,
)


def in_code(key: str) -> bool:
    return re.search(rf"`[^`]*\b{key}\b[^`]*`", PAGE) is not None


@pytest.mark.parametrize("kind", RECORDS)
def test_fields_of_records(kind: type[Any]) -> None:
    assert [entry.name for entry in fields(kind) if entry.init and not in_code(entry.name)] == []


def test_other_keys() -> None:
    keys = (*KEYS, *WORLD, *OWN, FRICTION, *PLACE, *START, *OF_SURFACE, "for_body", "pose", *ENDS)
    shapes = [key for own in SHAPES.values() for key in own]
    assert [key for key in (*keys, *shapes) if not in_code(key)] == []
    assert in_code("movers")
    assert [kind for kind in (*KINDS, *COMPOSED) if f'"{kind}"' not in PAGE] == []


def test_blocks_are_scenes(tmp_path: Path) -> None:
    letter_i(coarse=1).save(tmp_path / "hero.char")
    blocks = re.findall(r"```toml\n(.*?)```", PAGE, flags=re.DOTALL)
    assert len(blocks) == 3
    for number, text in enumerate(blocks):
        (tmp_path / f"{number}.toml").write_text(text)
        file = scene_files.read(tmp_path / f"{number}.toml")
        file.simulation().step()
