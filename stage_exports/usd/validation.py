"""An exported file is validated, whoever wrote it, and each fault is a sentence."""

from __future__ import annotations

from pathlib import Path

from warp_softbody.errors import InputError
from warp_softbody.stage_exports.usd.isolation import apart


def validate(path: str | Path) -> list[str]:
    """Return what is wrong with an exported file, a sentence for each fault."""
    try:
        return list(apart("find_faults", path))
    except InputError as error:
        return [str(error)]
