"""Pages of the documentation, their blocks of code and the commands that they tell."""

from __future__ import annotations

import re
import shlex
from pathlib import Path

ROOT = Path(__file__).parents[2]
PAGES = sorted([*ROOT.glob("*.md"), *(ROOT / "docs").glob("*.md")])
FENCE = re.compile(r"^```(\w*)\n(.*?)^```$", re.MULTILINE | re.DOTALL)
PYTHON = re.compile(r"^```python\n(.*?)^```$(?:\n\n```text\n(.*?)^```$)?", re.MULTILINE | re.DOTALL)
STARTS = ("warp-softbody ", "python -m ", "make ", "pip install ")


def python_blocks(text: str) -> list[tuple[str, str]]:
    """The blocks of a page that are marked as Python, each with the block of text right after it.

    That block shows what the Python prints; it is empty where there is none.
    """
    return PYTHON.findall(text)


def commands(text: str) -> list[list[str]]:
    """The words of each command on a page: in console blocks, indented blocks and inline code."""
    lines = [
        line
        for language, code in FENCE.findall(text)
        if language == "console"
        for line in code.splitlines()
    ]
    rest = FENCE.sub("", text)
    lines += re.findall(r"^    (.*)$", rest, re.MULTILINE)
    lines += re.findall(r"(?<!`)`([^`\n]+)`(?!`)", rest)
    told = [line.split(" #")[0].strip().removeprefix(".venv/bin/") for line in lines]
    return [
        shlex.split(line.replace("[--json]", "--json")) for line in told if line.startswith(STARTS)
    ]
