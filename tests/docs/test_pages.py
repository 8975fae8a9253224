"""Form of the pages: the length of lines, links between pages, and one version everywhere."""

from __future__ import annotations

import re
from pathlib import Path

import pytest

from tests.docs.pages import FENCE, PAGES, ROOT
from warp_softbody import __version__

LONGEST = 120


@pytest.mark.parametrize("page", PAGES, ids=lambda page: page.stem)
def test_lines_are_short(page: Path) -> None:
    """Rows of tables cannot be broken, nor can a link."""
    lines = page.read_text().splitlines()
    assert [
        (number, line)
        for number, line in enumerate(lines, 1)
        if len(line) > LONGEST and not line.startswith("|") and " " in line.strip()
    ] == []


@pytest.mark.parametrize("page", PAGES, ids=lambda page: page.stem)
def test_links_lead_somewhere(page: Path) -> None:
    links = re.findall(r"\]\(([^)#\s]+)", FENCE.sub("", page.read_text()))
    local = [link for link in links if "://" not in link]
    assert [link for link in local if not (page.parent / link).exists()] == []


def test_the_version_is_told_alike() -> None:
    assert f"\nversion: {__version__}\n" in (ROOT / "CITATION.cff").read_text()
