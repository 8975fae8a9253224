"""What a tet file declares of its own size, compared with what was read of it.

Some readers take half a file without a word, and formats without counts do not show that a line is
missing, except by a gap in the numbers of the cells.
"""

from __future__ import annotations

import struct
from collections.abc import Mapping
from pathlib import Path

import numpy as np

from warp_softbody.body.mesh_formats import counted, numbered
from warp_softbody.body.mesh_formats.contents import ReadingFailed
from warp_softbody.body.mesh_formats.declaration import Declaration

DECLARATIONS = {
    "abaqus": numbered.abaqus,
    "ansys": counted.ansys,
    "avsucd": counted.avsucd,
    "dolfin-xml": counted.dolfin,
    "flac3d": numbered.flac3d,
    "gmsh": counted.gmsh,
    "mdpa": numbered.mdpa,
    "medit": counted.medit,
    "nastran": numbered.nastran,
    "netgen": counted.netgen,
    "permas": numbered.permas,
    "su2": counted.su2,
    "tecplot": counted.tecplot,
    "tetgen": counted.tetgen,
    "ugrid": counted.ugrid,
    "vtk": counted.vtk,
    "vtu": counted.vtu,
    "xdmf": counted.xdmf,
}
"""By meshio's name of the format; the others are containers whose arrays carry their sizes."""


def declare(path: Path, file_format: str) -> Declaration:
    """What a file declares, by meshio's name of its format.

    Raises:
        ReadingFailed: it declares nothing that can be understood.
        OSError: it, or the file that belongs to it, cannot be opened.
    """
    if file_format not in DECLARATIONS:
        return Declaration()
    try:
        return DECLARATIONS[file_format](path)
    except (ValueError, IndexError, KeyError, OverflowError, struct.error) as error:
        raise ReadingFailed(f"its size cannot be understood: {error}") from error


def compare(declared: Declaration, points: int, cells: Mapping[str, int]) -> list[str]:
    """Sentences on cells whose numbers are missing or stand twice.

    Args:
        declared: what the file declares.
        points: how many were read.
        cells: how many of each kind were read.

    Raises:
        ReadingFailed: the file declares another number of points or cells.
    """
    solid = sum(n for kind, n in cells.items() if kind == "tetra")
    for what, wanted, found in (
        ("points", declared.points, points),
        ("cells", declared.cells, sum(cells.values())),
        ("solid cells", declared.solids, solid),
    ):
        if wanted is not None and wanted != found:
            raise ReadingFailed(f"it declares {wanted} {what}, but {found} can be read")
    notes = [_twice("points", declared.point_numbers), _twice("cells", declared.cell_numbers)]
    if declared.cut_off:
        notes.append("its last line has no end: see whether it was cut off")
    return [note for note in (*notes, _gap(declared.cell_numbers)) if note]


def _twice(what: str, numbers: list[int]) -> str:
    """A sentence where a number stands twice, else an empty text."""
    distinct, times = np.unique(np.array(numbers, dtype=np.int64), return_counts=True)
    repeated = distinct[times > 1]
    if not len(repeated):
        return ""
    return f"the number {repeated[0]} of its {what} stands more than once"


def _gap(numbers: list[int]) -> str:
    """A sentence where the numbers of cells leave some out, else an empty text.

    Numbers of points may have gaps: a tet that needs a missing point is refused by every reader.
    """
    if not numbers:
        return ""
    distinct = np.unique(np.array(numbers, dtype=np.int64))
    if distinct[0] > 1:
        return f"the numbers of its cells begin at {distinct[0]}: see whether cells are missing"
    steps = np.flatnonzero(np.diff(distinct) > 1)
    if not len(steps):
        return ""
    missing = int(distinct[-1] - distinct[0]) + 1 - len(distinct)
    return (
        f"the numbers of its {len(distinct)} cells leave out {missing}, the first of them "
        f"{distinct[steps[0]] + 1}: see whether cells are missing"
    )
