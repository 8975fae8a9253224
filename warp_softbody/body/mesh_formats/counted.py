"""Some formats declare their numbers of points and cells; these are found in the file here."""

from __future__ import annotations

import re
import struct
from collections.abc import Iterator
from pathlib import Path

from warp_softbody.body.mesh_formats.declaration import Declaration


def _counts(data: bytes, pattern: bytes) -> list[int]:
    """Numbers that a pattern's group catches, in order."""
    return [int(found) for found in re.findall(pattern, data, re.MULTILINE | re.IGNORECASE)]


def _one(data: bytes, what: str, pattern: bytes) -> int:
    """The number that a pattern's group catches, which must stand once in the file."""
    counts = _counts(data, pattern)
    if len(counts) != 1:
        raise ValueError(f"{what} stands {len(counts)} times in it, not once")
    return counts[0]


def vtk(path: Path) -> Declaration:
    """VTK legacy: POINTS, CELLS (from version 5 on one more, as offsets) and CELL_TYPES."""
    data = path.read_bytes()
    version = re.match(rb"#\s*vtk\s+DataFile\s+Version\s+(\d+)", data, re.IGNORECASE)
    if version is None:
        raise ValueError("no version of VTK in the first line")
    points = _one(data, "POINTS", rb"^\s*POINTS\s+(\d+)")
    cells = _one(data, "CELLS", rb"^\s*CELLS\s+(\d+)")
    cells -= int(version.group(1)) >= 5
    types = _one(data, "CELL_TYPES", rb"^\s*CELL_TYPES\s+(\d+)")
    if types != cells:
        raise ValueError(f"{cells} cells have {types} types")
    return Declaration(points=points, cells=cells)


def vtu(path: Path) -> Declaration:
    """VTK's XML: attributes of each piece."""
    data = path.read_bytes()
    points = _counts(data, rb"NumberOfPoints\s*=\s*[\"'](\d+)[\"']")
    cells = _counts(data, rb"NumberOfCells\s*=\s*[\"'](\d+)[\"']")
    if not points or not cells:
        raise ValueError("it gives no NumberOfPoints or no NumberOfCells")
    return Declaration(points=sum(points), cells=sum(cells))


def gmsh(path: Path) -> Declaration:
    """Gmsh 2 writes one count a section; 4.1 numbers of blocks and things, and least and most."""
    data = path.read_bytes()
    form = re.search(rb"\$MeshFormat\s+(\S+)\s+([01])\s+(\d+)", data)
    if form is None:
        raise ValueError("no $MeshFormat")
    version, binary = float(form.group(1)), form.group(2) == b"1"
    sizes = []
    for section in (b"Nodes", b"Elements"):
        start = re.search(rb"\$" + section + rb"[ \t]*\r?\n", data)
        if start is None:
            raise ValueError(f"no ${section.decode()}")
        if data.find(b"$End" + section, start.end()) < 0:
            raise ValueError(f"no $End{section.decode()}")
        if version < 4.0:
            sizes.append(int(data[start.end() :].split(maxsplit=1)[0]))
        elif binary:
            sizes.append(struct.unpack_from("=2Q", data, start.end())[1])
        else:
            sizes.append(int(data[start.end() :].split(maxsplit=2)[1]))
    return Declaration(points=sizes[0], cells=sizes[1])


def medit(path: Path) -> Declaration:
    """Medit: a keyword and a count before each list; binary files are left to their reader."""
    if path.suffix.lower() == ".meshb":
        return Declaration()
    data = path.read_bytes()
    kinds = rb"Edges|Triangles|Quadrilaterals|Tetrahedra|Prisms|Pyramids|Hexahedra|Hexaedra"
    return Declaration(
        points=_one(data, "Vertices", rb"^\s*Vertices\s+(\d+)"),
        cells=sum(_counts(data, rb"^\s*(?:" + kinds + rb")\s+(\d+)")),
    )


def netgen(path: Path) -> Declaration:
    """Netgen: a keyword and a count before each list, a comment perhaps between them."""
    if path.suffix.lower() == ".gz":
        return Declaration()
    data = path.read_bytes()
    between = rb"\s*(?:#[^\n]*\s+)*"
    return Declaration(
        points=_one(data, "points", rb"^points" + between + rb"(\d+)"),
        solids=_one(data, "volumeelements", rb"^volumeelements" + between + rb"(\d+)"),
    )


def su2(path: Path) -> Declaration:
    """SU2: NPOIN and NELEM, whose cells are those of the body and not of its markers."""
    data = path.read_bytes()
    return Declaration(
        points=_one(data, "NPOIN", rb"^\s*NPOIN\s*=\s*(\d+)"),
        solids=_one(data, "NELEM", rb"^\s*NELEM\s*=\s*(\d+)"),
    )


def tecplot(path: Path) -> Declaration:
    """Tecplot: nodes and elements of its one zone."""
    data = re.sub(rb'"[^"]*"', b"", path.read_bytes())
    zones = len(re.findall(rb"^\s*ZONE\b", data, re.MULTILINE | re.IGNORECASE))
    if zones != 1:
        raise ValueError(f"one zone is taken, but it holds {zones}")
    return Declaration(
        points=_one(data, "NODES", rb"\b(?:NODES|N)\s*=\s*(\d+)"),
        cells=_one(data, "ELEMENTS", rb"\b(?:ELEMENTS|E)\s*=\s*(\d+)"),
    )


def avsucd(path: Path) -> Declaration:
    """AVS: both counts in the first line that is no comment."""
    first = _first(_lines(path))
    return Declaration(points=int(first[0]), cells=int(first[1]))


def ugrid(path: Path) -> Declaration:
    """UGRID: seven counts in front; binary files are left to their reader."""
    if any(kind in path.name.lower() for kind in (".b8", ".lb8", ".r8", ".lr8", ".b4", ".lb4")):
        return Declaration()
    counts = [int(word) for word in path.read_bytes().split(maxsplit=7)[:7]]
    return Declaration(points=counts[0], cells=sum(counts[1:]))


def tetgen(path: Path) -> Declaration:
    """TetGen: counts in the first lines of both files, and a line for each point and tet."""
    nodes, tets = (_lines(path.with_suffix(suffix)) for suffix in (".node", ".ele"))
    points, cells = int(_first(nodes)[0]), int(_first(tets)[0])
    numbers = [[int(float(line[0])) for line in lines] for lines in (nodes, tets)]
    for what, given, found in zip(("points", "tets"), (points, cells), numbers, strict=True):
        if len(found) != given:
            raise ValueError(f"{given} {what} are declared, but there are lines of {len(found)}")
    return Declaration(points=points, cells=cells, cell_numbers=numbers[1])


def dolfin(path: Path) -> Declaration:
    """DOLFIN's XML: sizes of the lists, and a number with each of their members."""
    data = path.read_bytes()
    quoted = rb"=\s*[\"'](\d+)[\"']"
    return Declaration(
        points=_one(data, "<vertices>", rb"<vertices[^>]*?\bsize" + quoted),
        cells=_one(data, "<cells>", rb"<cells[^>]*?\bsize" + quoted),
        cell_numbers=_counts(data, rb"<tetrahedron[^>]*?\bindex" + quoted),
    )


def xdmf(path: Path) -> Declaration:
    """XDMF: rows of the items of geometry and topology, where each says them."""
    data = path.read_bytes()
    cells = _counts(data, rb"<Topology[^>]*?\b(?:NumberOfElements|Dimensions)\s*=\s*[\"'](\d+)")
    points = _counts(data, rb"<Geometry[^>]*>\s*<DataItem[^>]*?\bDimensions\s*=\s*[\"'](\d+)")
    return Declaration(
        points=points[0] if len(points) == 1 else None, cells=cells[0] if len(cells) == 1 else None
    )


def ansys(path: Path) -> Declaration:
    """Ansys: totals of points (10) and cells (12) in zone 0, and lists of them and faces (13)."""
    data = path.read_bytes()
    totals, listed = zip(*(_ansys_sizes(data, key) for key in (b"10", b"12", b"13")), strict=True)
    for what, total, found in zip(("points", "cells"), totals, listed, strict=False):
        if total is None:
            raise ValueError(f"the number of all {what} is not in it")
        if total != found:
            raise ValueError(f"it declares {total} {what}, but lists of {found}")
    return Declaration(points=listed[0], cells=listed[1] + listed[2])


def _ansys_sizes(data: bytes, key: bytes) -> tuple[int | None, int]:
    """The total of zone 0, None where there is none, and the sum of the other zones' lists."""
    number = rb"\s+([0-9a-fA-F]+)"
    zones = re.findall(rb"\(\s*(?:20|30)?" + key + rb"\s*\(\s*([0-9a-fA-F]+)" + 2 * number, data)
    sizes = [(int(zone, 16), int(last, 16) - int(first, 16) + 1) for zone, first, last in zones]
    totals = [size for zone, size in sizes if zone == 0]
    return (totals[0] if totals else None), sum(size for zone, size in sizes if zone != 0)


def _first(lines: Iterator[list[str]]) -> list[str]:
    """First of the lines of a file, which must hold one."""
    first = next(lines, None)
    if first is None:
        raise ValueError("it holds no line but comments")
    return first


def _lines(path: Path) -> Iterator[list[str]]:
    """Words of each line that is neither empty nor a comment."""
    with path.open(encoding="utf-8", errors="replace") as stream:
        for line in stream:
            words = line.partition("#")[0].split()
            if words:
                yield words
