"""The files of the pages, as a server hands them out and as one file holds them."""

from __future__ import annotations

import gzip
import re
from functools import cache
from pathlib import Path

PAGE = Path(__file__).parent / "page"
THREE = "three.min.js"
IMPORT = re.compile(r'^import \{[^}]*\} from "\./([a-z0-9_]+)\.js";\n', re.MULTILINE)
EXPORT = re.compile(r"^export ", re.MULTILINE)
TYPES = {".html": "text/html", ".css": "text/css", ".js": "text/javascript"}


@cache
def served() -> dict[str, bytes]:
    """The files that a live page asks for by their names; three.js is still packed by gzip."""
    files = {path.name: path.read_bytes() for path in PAGE.iterdir() if path.suffix in TYPES}
    return {**files, THREE: packed_three()}


def packed_three() -> bytes:
    """three.js, minified and packed by gzip."""
    return (PAGE / "vendor" / f"{THREE}.gz").read_bytes()


def three_licence() -> str:
    """The licence of three.js, which goes wherever it goes."""
    return (PAGE / "vendor" / "LICENSE").read_text(encoding="utf-8")


@cache
def player_script() -> str:
    """three.js and the player of takes as one script that imports nothing."""
    library = gzip.decompress(packed_three()).decode()
    return f"{library}\n{linked('take.js')}"


def linked(entry: str) -> str:
    """A module and all that it imports as one, each after those that it imports.

    The modules of the page import one another by name alone and share no name of the top level
    (a test sees to it), so that they can stand one after the other without these lines.
    """
    texts: dict[str, str] = {}

    def visit(name: str) -> None:
        if name in texts:
            return
        source = (PAGE / name).read_text(encoding="utf-8")
        texts[name] = ""
        for imported in IMPORT.findall(source):
            visit(f"{imported}.js")
        # in the order in which they were left, not entered
        del texts[name]
        texts[name] = EXPORT.sub("", IMPORT.sub("", source))

    visit(entry)
    return "\n".join(texts.values())
