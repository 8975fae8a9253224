"""A PLY file has elements with properties, as text or binary; points and faces are read."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt

from warp_softbody.body.mesh_formats.polygons import Polygons, word_lines

TYPES = {
    "char": "i1", "uchar": "u1", "short": "i2", "ushort": "u2", "int": "i4", "uint": "u4",
    "float": "f4", "double": "f8", "int8": "i1", "uint8": "u1", "int16": "i2", "uint16": "u2",
    "int32": "i4", "uint32": "u4", "float32": "f4", "float64": "f8",
}  # fmt: skip
ORDERS = {"ascii": "", "binary_little_endian": "<", "binary_big_endian": ">"}
CORNERS = ("vertex_indices", "vertex_index")


@dataclass(frozen=True)
class _Property:
    """One property: its name, the type of its values, and that of its length where it is a list."""

    name: str
    kind: str
    length: str = ""


@dataclass(frozen=True)
class _Element:
    """One element of the header: its name, how many there are, and their properties."""

    name: str
    count: int
    properties: tuple[_Property, ...]


Row = list[Any]
Columns = list[Any]
"""Values of each property: an array, or a tuple where the lengths of lists differ."""


def read_ply(path: Path) -> Polygons:
    """Points and polygons; normals, colours and other elements are left out."""
    data = path.read_bytes()
    order, elements, body = _header(data)
    names = [element.name for element in elements]
    for name in ("vertex", "face"):
        if names.count(name) != 1:
            raise ValueError(f"it has {names.count(name)} elements {name!r}")
    tables = _text_rows(elements, body) if order == "" else _binary_rows(elements, body, order)
    vertex, face = elements[names.index("vertex")], elements[names.index("face")]
    axes = [_column(vertex, (axis,)) for axis in "xyz"]
    corners = _column(face, CORNERS)
    if not face.properties[corners].length or face.properties[corners].kind[0] == "f":
        raise ValueError("the corners of its faces are no lists of integers")
    if not vertex.count or not face.count:
        raise ValueError(f"it has {vertex.count} points and {face.count} faces")
    points = np.stack([np.asarray(tables["vertex"][axis]) for axis in axes], axis=1)
    return Polygons(points, tables["face"][corners])


def _column(element: _Element, names: tuple[str, ...]) -> int:
    for index, one in enumerate(element.properties):
        if one.name in names:
            return index
    raise ValueError(f"its element {element.name!r} has no property {names[0]!r}")


def _header(data: bytes) -> tuple[str, list[_Element], bytes]:
    """Byte order ("" for text), elements, and what follows the header."""
    end = data.find(b"end_header")
    line_end = data.find(b"\n", end)
    if not data.startswith(b"ply") or end < 0 or line_end < 0:
        raise ValueError("it has no header from 'ply' to 'end_header'")
    order: str | None = None
    elements: list[_Element] = []
    for line in data[:end].decode("ascii", errors="replace").splitlines()[1:]:
        words = line.split()
        if not words or words[0] in ("comment", "obj_info"):
            continue
        if words[0] == "format" and len(words) == 3:
            order = ORDERS.get(words[1])
        elif words[0] == "element" and len(words) == 3:
            elements.append(_Element(words[1], int(words[2]), ()))
        elif words[0] == "property" and elements:
            last = elements[-1]
            elements[-1] = _Element(last.name, last.count, (*last.properties, _property(words)))
        else:
            raise ValueError(f"its header has the line {line[:60]!r}")
    if order is None or any(element.count < 0 for element in elements):
        raise ValueError("its header has no known format, or a negative count")
    return order, elements, data[line_end + 1 :]


def _property(words: list[str]) -> _Property:
    if words[1] == "list" and len(words) == 5 and words[2] in TYPES and words[3] in TYPES:
        return _Property(words[4], TYPES[words[3]], TYPES[words[2]])
    if len(words) == 3 and words[1] in TYPES:
        return _Property(words[2], TYPES[words[1]])
    raise ValueError(f"its header has the property {' '.join(words[1:])[:60]!r}")


def _text_rows(elements: list[_Element], body: bytes) -> dict[str, Columns]:
    lines = word_lines(body, comment="\0")
    wanted = sum(element.count for element in elements if element.properties)
    if len(lines) != wanted:
        raise ValueError(f"it declares {wanted} points, faces and others, but has {len(lines)}")
    rows = iter(lines)

    def table(element: _Element) -> list[Row]:
        return [_text_row(element, next(rows)) for _ in range(element.count)]

    return {
        element.name: list(zip(*table(element), strict=True))
        for element in elements
        if element.properties
    }


def _text_row(element: _Element, words: list[str]) -> Row:
    row: Row = []
    place = 0
    for one in element.properties:
        value = float if one.kind[0] == "f" else int
        if one.length:
            end = place + 1 + int(words[place])
            row.append([value(word) for word in words[place + 1 : end]])
            place = end
        else:
            row.append(value(words[place]))
            place += 1
    if place != len(words):
        raise ValueError(f"a {element.name} has {len(words)} numbers, not {place}")
    return row


def _binary_rows(elements: list[_Element], body: bytes, order: str) -> dict[str, Columns]:
    tables: dict[str, Columns] = {}
    place = 0
    for element in elements:
        even = _even_rows(element, body, place, order)
        if even is None:
            rows, place = _uneven_rows(element, body, place, order)
            tables[element.name] = list(zip(*rows, strict=True))
        else:
            tables[element.name] = [even[f"v{k}"] for k in range(len(element.properties))]
            place += even.nbytes
    if place != len(body):
        raise ValueError(f"{len(body) - place} bytes follow what it declares")
    return tables


def _even_rows(
    element: _Element, body: bytes, place: int, order: str
) -> npt.NDArray[np.void] | None:
    """All rows at once where every list is as long as in the first row; else None."""
    fields: list[Any] = []
    lengths: list[tuple[str, int]] = []
    at = place
    for index, one in enumerate(element.properties):
        size = int(one.kind[1])
        if one.length:
            width = int(one.length[1])
            if at + width > len(body):
                return None
            length = int(np.frombuffer(body, order + one.length, 1, at)[0])
            if length < 0 or at + width + length * size > len(body):
                return None
            fields.append((f"n{index}", order + one.length))
            fields.append((f"v{index}", order + one.kind, (length,)))
            lengths.append((f"n{index}", length))
            at += width + length * size
        else:
            fields.append((f"v{index}", order + one.kind))
            at += size
    kind = np.dtype(fields)
    if not element.count or kind.itemsize * element.count > len(body) - place:
        return None
    rows = np.frombuffer(body, kind, element.count, place)
    return rows if all((rows[name] == length).all() for name, length in lengths) else None


def _uneven_rows(element: _Element, body: bytes, place: int, order: str) -> tuple[list[Row], int]:
    """Row by row, and the place after the last one."""
    rows: list[Row] = []
    if element.properties:
        for _ in range(element.count):
            row: Row = []
            for one in element.properties:
                count = 1
                if one.length:
                    count = int(_numbers(body, order + one.length, 1, place)[0])
                    place += int(one.length[1])
                values = _numbers(body, order + one.kind, count, place).tolist()
                place += count * int(one.kind[1])
                row.append(values if one.length else values[0])
            rows.append(row)
    return rows, place


def _numbers(body: bytes, kind: str, count: int, place: int) -> npt.NDArray[Any]:
    if count < 0 or place + count * int(kind[-1]) > len(body):
        raise ValueError("it ends before all that it declares")
    return np.frombuffer(body, kind, count, place)


def vertex_columns(path: Path) -> dict[str, npt.NDArray[Any]]:
    """Numbers of each property of the points that is no list, by its name.

    Raises:
        ValueError: the file is no PLY.
    """
    order, elements, body = _header(path.read_bytes())
    tables = _text_rows(elements, body) if order == "" else _binary_rows(elements, body, order)
    vertex = next((element for element in elements if element.name == "vertex"), None)
    if vertex is None or not vertex.count:
        raise ValueError("it has no points")
    columns = zip(vertex.properties, tables["vertex"], strict=True)
    return {one.name: np.asarray(column) for one, column in columns if not one.length}
