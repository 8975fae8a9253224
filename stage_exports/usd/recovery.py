"""A stage is made of the chunks that an interrupted take left."""

from __future__ import annotations

from pathlib import Path

from warp_softbody.errors import InputError, OutputError
from warp_softbody.inputs import input_kinds
from warp_softbody.stage_exports.conventions import EXTENSIONS, checked_target
from warp_softbody.stage_exports.usd.chunks import abandon, merged
from warp_softbody.stage_exports.usd.claims import Claim, folders_of, left_behind
from warp_softbody.stage_exports.usd.merging import closed_chunks, reason
from warp_softbody.stage_exports.usd.stage_files import may_replace


def recover(path: str | Path, out: str | Path | None = None) -> Path:
    """Make a stage of the chunks that an interrupted take left beside `path`; returns its path.

    Of several such takes it is the one that was written to last; the others stay.

    Args:
        path: that the take was to write.
        out: of the stage, where it is to stand elsewhere, maybe on another disk.

    Raises:
        OutputError: there are none, the take is still being written, a chunk is damaged, or a file
            stands there that the take was not to replace; the chunks are kept.
    """
    return recovered(path, out)[0]


def recovered(path: str | Path, out: str | Path | None = None) -> tuple[Path, int]:
    """The path that `recover` returns, and the number of frames."""
    asked = checked_target(path, extensions=EXTENSIONS) if out is None else _named(path)
    target = asked if out is None else checked_target(out, extensions=EXTENSIONS)
    claims = left_behind(asked)
    try:
        chosen = next((one for one in claims if closed_chunks(one.folder)), None)
        if chosen is None:
            raise OutputError(_nothing(asked, claims))
        if not may_replace(chosen.folder, target):
            raise OutputError(
                f"{str(target)!r} stays as it is, since the take that is to be recovered was not "
                "to replace it; choose another name by --out (out= in Python)"
            )
        frames = _made(chosen, target)
        chosen.remove()
    finally:
        for one in claims:
            abandon(one)
    return target, frames


def _named(path: str | Path) -> Path:
    """Where a take was to be written, on a disk that may be full by now."""
    return input_kinds.path("path of a take to recover", path).expanduser().absolute()


def _made(chosen: Claim, target: Path) -> int:
    try:
        return merged(chosen.folder, target, trusted=False)
    except (OSError, InputError) as error:
        raise OutputError(
            f"{str(target)!r} could not be recovered ({reason(error)}); "
            f"the chunks are kept in {str(chosen.folder)!r}"
        ) from error


def _nothing(target: Path, free: list[Claim]) -> str:
    if set(folders_of(target)) - {one.folder for one in free}:
        return f"{str(target)!r} is still being written; recover it once that has ended"
    return f"nothing to recover for {str(target)!r}: no chunks stand beside it"
