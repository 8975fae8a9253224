"""Formats without counts have a numbered line for each point and cell; gaps show missing lines."""

from __future__ import annotations

from pathlib import Path

from warp_softbody.body.mesh_formats.declaration import Declaration


def _text(path: Path) -> list[str]:
    return path.read_text(encoding="utf-8", errors="replace").splitlines()


def _cut_off(path: Path) -> bool:
    """Whether the last line has no end."""
    return not path.read_bytes().endswith((b"\n", b"\r"))


def abaqus(path: Path) -> Declaration:
    """Abaqus: data lines after *NODE and *ELEMENT.

    The cells of long types go on in the next line where a line ends with a comma.
    """
    points: list[int] = []
    cells: list[int] = []
    taken: list[int] | None = None
    long_type = goes_on = False
    for line in _text(path):
        if line.startswith("**") or not line.strip():
            continue
        if line.startswith("*"):
            keyword = line.partition(",")[0].strip("* \t").upper()
            taken = {"NODE": points, "ELEMENT": cells}.get(keyword)
            long_type = keyword == "ELEMENT" and "C3D4" not in line.upper()
            if keyword == "INCLUDE":
                raise ValueError("*INCLUDE of another file is not taken")
        elif taken is not None and not goes_on:
            taken.append(int(line.partition(",")[0]))
        goes_on = long_type and line.rstrip().endswith(",")
    return Declaration(
        points=len(points), point_numbers=points, cell_numbers=cells, cut_off=_cut_off(path)
    )


def flac3d(path: Path) -> Declaration:
    """FLAC3D: lines G of points, Z of solid cells; binary files are left to their reader."""
    if b"\0" in path.open("rb").read(8):
        return Declaration()
    words = [line.split() for line in _text(path)]
    points = [int(line[1]) for line in words if line and line[0] == "G"]
    cells = [int(line[2]) for line in words if line and line[0] == "Z"]
    for line in words:
        if line and line[0] not in ("G", "Z", "F", "*", "ZGROUP", "FGROUP") and line[0][0] in "GZF":
            raise ValueError(f"a line begins with {line[0]!r}")
    return Declaration(
        points=len(points),
        solids=len(cells),
        point_numbers=points,
        cell_numbers=cells,
        cut_off=_cut_off(path),
    )


def mdpa(path: Path) -> Declaration:
    """Kratos: lines between Begin and End; nodes must be numbered from 1 in order."""
    lists: dict[str, list[int]] = {"Nodes": [], "Elements": [], "Conditions": []}
    inside = ""
    for line in _text(path):
        words = line.split()
        if words[:1] == ["Begin"]:
            inside = words[1]
        elif words[:1] == ["End"]:
            inside = ""
        elif words and inside in lists:
            lists[inside].append(int(words[0]))
    nodes = lists["Nodes"]
    if nodes != list(range(1, len(nodes) + 1)):
        raise ValueError("its nodes are not numbered from 1 in order")
    cells = lists["Elements"]
    count = len(cells) + len(lists["Conditions"])
    return Declaration(points=len(nodes), cells=count, cell_numbers=cells)


def permas(path: Path) -> Declaration:
    """PERMAS: lines after $COOR and $ELEMENT, each going on after a line that ends with !."""
    points: list[int] = []
    cells: list[int] = []
    taken: list[int] | None = None
    goes_on = False
    for line in _text(path):
        if line.startswith(("$", "!")) or not line.strip():
            keyword = line.strip("$").split(" ")[0].strip().upper()
            taken = {"COOR": points, "ELEMENT": cells}.get(keyword)
        elif taken is not None and not goes_on:
            taken.append(int(line.split()[0]))
        goes_on = line.rstrip().endswith("!")
    keywords = [line.split()[0].upper() for line in _text(path) if line.startswith("$")]
    if keywords.count("$ENTER") != keywords.count("$EXIT"):
        raise ValueError("it ends before $EXIT")
    return Declaration(points=len(points), point_numbers=points, cell_numbers=cells)


def nastran(path: Path) -> Declaration:
    """Nastran: cards GRID and C..., in fields of 8 or 16 columns or between commas."""
    points: list[int] = []
    cells: list[int] = []
    for line in _text(path):
        keyword, number = _card(line)
        if keyword == "GRID":
            points.append(int(number))
        elif keyword in CELL_CARDS:
            cells.append(int(number))
        elif keyword.startswith("C") and number.isdigit() and keyword not in OTHER_CARDS:
            raise ValueError(f"the card {keyword} is not known")
    return Declaration(points=len(points), point_numbers=points, cell_numbers=cells)


CELL_CARDS = (
    *("CTETRA", "CHEXA", "CPENTA", "CPYRA"),
    *("CTRIA3", "CTRIA6", "CTRIAR", "CQUAD4", "CQUAD8", "CQUAD", "CQUADR", "CSHEAR", "CTRIAX6"),
    *("CBAR", "CBEAM", "CROD", "CONROD", "CTUBE", "CBUSH", "CBUSH1D", "CGAP", "CVISC"),
    *("CELAS1", "CELAS2", "CELAS3", "CELAS4", "CDAMP1", "CDAMP2", "CDAMP3", "CDAMP4"),
    *("CMASS1", "CMASS2", "CMASS3", "CMASS4", "CONM1", "CONM2", "CFAST", "CWELD"),
)
"""Cards on cells, springs and masses, whose numbers are of one series."""

OTHER_CARDS = ("CORD1C", "CORD1R", "CORD1S", "CORD2C", "CORD2R", "CORD2S", "CSUPER", "CSUPEXT")
"""Cards on frames of reference and superelements."""


def _card(line: str) -> tuple[str, str]:
    """Keyword and first field of a line; both empty for comments and continuations."""
    if not line[:1].isalpha():
        return "", ""
    if "," in line:
        fields = line.split(",")
        return fields[0].strip().rstrip("*").upper(), fields[1].strip()
    keyword = line[:8].strip()
    width = 16 if keyword.endswith("*") else 8
    return keyword.rstrip("*").upper(), line[8 : 8 + width].strip()
