"""TOML is written so that it comes back, and every key's line is known."""

from __future__ import annotations

import sys
from typing import Any

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from warp_softbody.scene_files.toml_lines import lines_of
from warp_softbody.scene_files.toml_text import toml_text

if sys.version_info >= (3, 11):
    import tomllib
else:
    import tomli as tomllib

TEXTS = st.text(st.characters(exclude_categories=("Cs", "Cc")), max_size=12)
SCALARS = st.one_of(
    st.booleans(),
    st.integers(-(2**40), 2**40),
    st.floats(allow_nan=False, allow_infinity=False),
    TEXTS,
)
VALUES = st.recursive(
    SCALARS,
    lambda inner: st.lists(inner, max_size=4) | st.dictionaries(TEXTS, inner, max_size=4),
    max_leaves=20,
)


@settings(deadline=None, max_examples=200)
@given(st.dictionaries(TEXTS, VALUES, max_size=5))
def test_values_come_back_to_the_last_bit(values: dict[str, Any]) -> None:
    text = toml_text(values)
    assert tomllib.loads(text) == values
    lines_of(text)


TEXT = '''\
# first
name = "a # b"   # [no.table]
long = [
    1, # one
    [2,
     3],
]
text = """
[not.a.table]
"""
"quo.ted" = {x = 1, y = {z = 'a'}}

[world]
gravity . size = 1

[[bodies]]
name = "one"
[bodies.material]
density = 2

[[bodies]]
[[bodies.fibers]]
kind = 'x'
[[bodies.fibers]]
kind = "y"
'''


@pytest.mark.parametrize(
    ("place", "line"),
    [
        (("name",), 2),
        (("long",), 3),
        (("long", 0), 4),
        (("long", 1, 1), 6),
        (("text",), 8),
        (("quo.ted",), 11),
        (("quo.ted", "y", "z"), 11),
        (("world",), 13),
        (("world", "gravity", "size"), 14),
        (("bodies", 0), 16),
        (("bodies", 0, "name"), 17),
        (("bodies", 0, "material", "density"), 19),
        (("bodies", 1), 21),
        (("bodies", 1, "fibers", 1, "kind"), 25),
    ],
)
def test_lines_are_found(place: tuple[str | int, ...], line: int) -> None:
    tomllib.loads(TEXT)
    assert lines_of(TEXT)[place] == line
