"""A file of JSON lines that grows by one a run; a line that was torn is passed over."""

from __future__ import annotations

import json
from collections.abc import Mapping
from pathlib import Path
from typing import Any


class JsonLines:
    """Records on disk, each there at once and in one piece.

    Attributes:
        records: those that the file held at first.

    Raises:
        OSError: the file cannot be read, or added to.
    """

    def __init__(self, path: Path | None) -> None:
        """Read what there is; None keeps nothing."""
        self._path = path
        text = path.read_bytes() if path is not None and path.is_file() else b""
        self._torn = bool(text) and not text.endswith(b"\n")
        self.records = [found for line in text.splitlines() if (found := _record(line))]

    def add(self, record: Mapping[str, Any]) -> None:
        """Keep a record."""
        if self._path is None:
            return
        with self._path.open("ab", buffering=0) as file:
            file.write((("\n" if self._torn else "") + json.dumps(dict(record)) + "\n").encode())
        self._torn = False


def _record(line: bytes) -> dict[str, Any]:
    """What a line holds; {} where it is torn or no object."""
    try:
        found = json.loads(line)
    except ValueError:
        return {}
    return found if isinstance(found, dict) else {}
