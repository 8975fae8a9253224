"""A finished stage is written again in another form, chosen by the name of the file."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from pathlib import Path

from warp_softbody.inputs import input_kinds
from warp_softbody.stage_exports.conventions import EXTENSIONS, checked_target
from warp_softbody.stage_exports.forms.arrays import write_arrays
from warp_softbody.stage_exports.forms.glb import write_glb
from warp_softbody.stage_exports.forms.paraview import write_series
from warp_softbody.stage_exports.usd.reader import Take, read_takes
from warp_softbody.stage_exports.usd.repacking import repack

WRITERS: dict[str, Callable[[Path, Sequence[Take]], None]] = {
    ".npz": write_arrays,
    ".pvd": write_series,
    ".glb": write_glb,
}
FORMS = (*WRITERS, *EXTENSIONS)


def convert(stage: str | Path, path: str | Path) -> Path:
    """Write a stage in another form; returns the path of the new file.

    Args:
        stage: that a `StageWriter` wrote.
        path: `.npz` (arrays of all bodies), `.pvd` (tets and velocities for ParaView, a `.vtu` a
            frame and body in a folder beside it), `.glb` (skins that move by morph targets), or
            another kind of USD file; an older file is replaced in one step.

    Raises:
        InputError: the stage is none or is damaged.
        OutputError: the path cannot be written.
        MissingExtraError: a `.glb` needs the extra `glb`.
    """
    source = input_kinds.path("stage to convert", stage)
    target = checked_target(path, extensions=FORMS)
    takes = read_takes(source)
    writer = WRITERS.get(target.suffix.lower())
    if writer is None:
        repack(source, target)
    else:
        writer(target, takes)
    return target
