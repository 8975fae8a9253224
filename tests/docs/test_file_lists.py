"""The lists of files to open name files that exist, and as many as their headings say."""

from __future__ import annotations

import re

import pytest

from tests.docs.pages import ROOT

LIST = re.compile(r"^##+ ([^\n]+) \((\d+) files\)\n(.*?)(?=^##|\Z)", re.MULTILINE | re.DOTALL)
LISTS = [
    (title, int(count), body)
    for page in ("CONTRIBUTING.md", "docs/architecture.md")
    for title, count, body in LIST.findall((ROOT / page).read_text())
]
MOST = {
    "One controlled step": 22,
    "A law of friction": 9,
    "An element": 6,
    "A preconditioner": 6,
}
"""Files to open at most; where a change needs more, its concerns have grown apart."""


@pytest.mark.parametrize(("title", "count", "body"), LISTS, ids=[title for title, *_ in LISTS])
def test_files_of_a_list_exist(title: str, count: int, body: str) -> None:
    files = re.findall(r"^\d+\. `([^`]+)`", body, re.MULTILINE)
    assert len(files) == count <= MOST.get(title, count)
    assert [file for file in files if not (ROOT / file).is_file()] == []


def test_no_list_is_missing() -> None:
    assert MOST.keys() <= {title for title, *_ in LISTS}
