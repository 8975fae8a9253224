"""Tets of a take as a series of VTU files, with the PVD file by which ParaView opens them."""

from __future__ import annotations

import shutil
from collections.abc import Sequence
from pathlib import Path
from xml.sax.saxutils import quoteattr

import meshio

from warp_softbody.atomic_files import private_folder, replace_text
from warp_softbody.errors import OutputError
from warp_softbody.stage_exports.usd.reader import Take

FOLDER = "{}_frames"
"""Of the VTU files, beside the PVD file of that name."""


def write_series(target: Path, takes: Sequence[Take]) -> None:
    """Points, tets, velocities and the rest shape of every body and frame.

    The files are made in a folder of another name, which takes the place of an older one.

    Raises:
        OutputError: a file could not be written, or that folder holds something else.
    """
    folder = target.with_name(FOLDER.format(target.stem))
    try:
        _check_older(folder)
        made = private_folder(target.parent)
        try:
            names = _write_frames(made, takes)
            shutil.rmtree(folder, ignore_errors=True)
            made.rename(folder)
            folder.chmod(0o755)
        finally:
            shutil.rmtree(made, ignore_errors=True)
        replace_text(target, _collection(folder.name, names, takes))
    except OSError as error:
        raise OutputError(
            f"{str(target)!r} could not be written: {error.strerror or error}"
        ) from error


def _check_older(folder: Path) -> None:
    """Refuse to take the place of a folder that holds anything but frames."""
    older = folder.iterdir() if folder.exists() else ()
    others = [path.name for path in older if path.suffix != ".vtu"]
    if others:
        raise OutputError(
            f"the frames would take the place of {str(folder)!r}, which holds {min(others)!r} too"
        )


def _write_frames(folder: Path, takes: Sequence[Take]) -> list[list[str]]:
    """Names of the files, frame by frame."""
    digits = len(str(len(takes[0]) - 1))
    names = [
        [f"{take.name}_{frame:0{digits}d}.vtu" for take in takes] for frame in range(len(takes[0]))
    ]
    for frame, own in enumerate(names):
        for take, name in zip(takes, own, strict=True):
            mesh = meshio.Mesh(
                take.tet_points[frame],
                [("tetra", take.tets)],
                point_data={"velocity": take.velocities[frame], "rest": take.rest},
            )
            mesh.write(folder / name, file_format="vtu", binary=True)
    return names


def _collection(folder: str, names: Sequence[Sequence[str]], takes: Sequence[Take]) -> str:
    lines = [
        f"    <DataSet timestep={quoteattr(repr(float(time)))} part={quoteattr(str(part))} "
        f"file={quoteattr(f'{folder}/{name}')}/>"
        for time, own in zip(takes[0].times, names, strict=True)
        for part, name in enumerate(own)
    ]
    return "\n".join(
        [
            '<?xml version="1.0"?>',
            '<VTKFile type="Collection" version="0.1" byte_order="LittleEndian">',
            "  <Collection>",
            *lines,
            "  </Collection>",
            "</VTKFile>",
            "",
        ]
    )
