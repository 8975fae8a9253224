"""A stage is written again as another kind of USD file, read in a process of its own."""

from __future__ import annotations

from pathlib import Path

from warp_softbody.atomic_files import replacing
from warp_softbody.errors import OutputError
from warp_softbody.stage_exports.usd.chunks import USD
from warp_softbody.stage_exports.usd.isolation import apart
from warp_softbody.stage_exports.usd.merging import reason
from warp_softbody.stage_exports.usd.textures import keep_textures


def repack(source: Path, target: Path) -> None:
    """Write a stage as the kind that the new name has.

    Raises:
        InputError: it is none.
        OutputError: the new file could not be written.
    """
    try:
        with USD, replacing(target) as path:
            textures = apart("rewrite", source, str(path))
            keep_textures(target.parent, textures)
    except OSError as error:
        raise OutputError(f"{str(target)!r} could not be written: {reason(error)}") from error
