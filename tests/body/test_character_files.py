"""Characters in files: what is read is what was written, and damaged files are refused."""

from __future__ import annotations

import json
from dataclasses import replace
from pathlib import Path
from typing import Any
from zipfile import ZIP_DEFLATED, ZipFile

import numpy as np
import pytest

from warp_softbody import Character, DirectionalFriction, Skin, SkinMaterial, characters
from warp_softbody.errors import InputError, OutputError


def letter() -> Character:
    """A shipped letter with something in every field."""
    texture = b"\x89PNG and so on"
    points = np.array([[0.0, 0.0, 0.5], [0.1, 0.0, 0.5], [0.0, 0.1, 0.5]])
    skin = Skin(
        points=points,
        faces=np.array([[0, 1, 2]], dtype=np.int32),
        texture_points=np.array([[0.0, 0.0], [1.0, 0.0], [0.0, 1.0]]),
        texture_faces=np.array([[0, 1, 2]], dtype=np.int32),
        materials=(SkinMaterial(name="label", texture=texture),),
    )
    friction = DirectionalFriction(region="base", factors=(1.0, 2.0, 3.0, 4.0))
    fixed = np.array([3, 5], dtype=np.int32)
    return replace(characters.letter_i(), directional_friction=(friction,), fixed=fixed, skin=skin)


def test_what_is_read_is_what_was_written(tmp_path: Path) -> None:
    path = tmp_path / "letter.char"
    letter().save(path)
    assert Character.load(path) == letter()


def test_the_same_character_gives_the_same_bytes(tmp_path: Path) -> None:
    one, other = tmp_path / "one.char", tmp_path / "other.char"
    letter().save(one)
    Character.load(one).save(other)
    assert one.read_bytes() == other.read_bytes()


def test_nothing_in_it_is_run(tmp_path: Path) -> None:
    path = tmp_path / "letter.char"
    letter().save(path)
    poisoned = _changed(path, tmp_path, array=np.array([object()], dtype=object))
    with pytest.raises(InputError, match="it does not hold a character"):
        Character.load(poisoned)


@pytest.mark.parametrize(
    ("key", "value", "sentence"),
    [
        ("version", 99, "version 99"),
        ("format", "movie", "'movie'"),
        ("name", "no name", "Character.name"),
        ("color", [2.0, 0.0, 0.0], "Character.color"),
        ("material", {"young_modulus": -1.0}, "young_modulus"),
        ("material", {"colour": 1.0}, "does not hold a character"),
        ("mesh", {"points": "array_77.npy"}, "does not hold a character"),
        ("muscles", 3, "does not hold a character"),
        ("regions", {"base": "array_0.npy"}, "region 'base'"),
    ],
)
def test_what_no_character_has_is_refused(
    tmp_path: Path, key: str, value: object, sentence: str
) -> None:
    path = tmp_path / "letter.char"
    letter().save(path)
    with pytest.raises(InputError, match=sentence) as caught:
        Character.load(_changed(path, tmp_path, **{key: value}))
    assert "changed.char" in str(caught.value)


@pytest.mark.parametrize("data", [b"", b"PK\x03\x04half of it", b"solid stl"])
def test_a_file_of_another_kind_is_refused(tmp_path: Path, data: bytes) -> None:
    path = tmp_path / "other.char"
    path.write_bytes(data)
    with pytest.raises(InputError, match="cannot be read as a character"):
        Character.load(path)


def test_a_file_that_unpacks_to_too_much_is_refused(tmp_path: Path) -> None:
    path = tmp_path / "bomb.char"
    with ZipFile(path, "w", ZIP_DEFLATED) as archive, archive.open("zeros.npy", "w") as entry:
        for _ in range(1100):
            entry.write(bytes(2**20))
    with pytest.raises(InputError, match="unpacks to"):
        Character.load(path)


def test_paths(tmp_path: Path) -> None:
    with pytest.raises(InputError, match=r"must end in \.char"):
        letter().save(tmp_path / "letter.zip")
    with pytest.raises(InputError, match="there is no such file"):
        Character.load(tmp_path / "none.char")
    with pytest.raises(OutputError, match="cannot be written"):
        letter().save(tmp_path / "no folder" / "letter.char")


def _changed(path: Path, folder: Path, array: Any = None, **values: object) -> Path:
    """A copy of a character's file in which values, or all arrays, are others."""
    result = folder / "changed.char"
    with ZipFile(path) as old, ZipFile(result, "w") as new:
        for name in old.namelist():
            if name == "character.json":
                new.writestr(name, json.dumps({**json.loads(old.read(name)), **values}))
            elif array is not None:
                with new.open(name, "w") as entry:
                    np.lib.format.write_array(entry, array, allow_pickle=True)
            else:
                new.writestr(name, old.read(name))
    return result
