"""One small body in every format that can be written without a further package."""

from __future__ import annotations

import contextlib
import io
import itertools
import re
from collections.abc import Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import meshio
import numpy as np
import trimesh

from warp_softbody.body.mesh import TetMesh

CELLS = 2
"""Cubes of the body along each axis, of six tets each."""


@dataclass(frozen=True, kw_only=True)
class Kind:
    """One format.

    Attributes:
        name: of the format and its variant.
        file: name of the file that is read.
        surface: whether it holds the body's surface in place of its tets.
        options: keyword arguments of meshio's writer.
    """

    name: str
    file: str
    surface: bool = False
    options: Mapping[str, Any] = field(default_factory=dict)

    @property
    def sizes(self) -> tuple[int, int]:
        """Numbers of points and cells of the body."""
        body = make_body()
        if self.surface:
            return len(body.surface_nodes), len(body.surface)
        return len(body.points), len(body.tets)


def _tets(name: str, file: str, **options: object) -> Kind:
    return Kind(name=name, file=file, options=options)


def _surface(name: str, file: str, **options: object) -> Kind:
    return Kind(name=name, file=file, surface=True, options=options)


KINDS = (
    _tets("abaqus", "s.inp"),
    _tets("ansys_text", "s.msh", file_format="ansys", binary=False),
    _tets("ansys_binary", "s.msh", file_format="ansys", binary=True),
    _tets("avs", "s.avs"),
    _tets("dolfin", "s.xml"),
    _tets("flac3d_text", "s.f3grid", binary=False),
    _tets("flac3d_binary", "s.f3grid", binary=True),
    _tets("gmsh22_text", "s.msh", file_format="gmsh22", binary=False),
    _tets("gmsh22_binary", "s.msh", file_format="gmsh22", binary=True),
    _tets("gmsh41_text", "s.msh", file_format="gmsh", binary=False),
    _tets("gmsh41_binary", "s.msh", file_format="gmsh", binary=True),
    _tets("mdpa", "s.mdpa"),
    _tets("medit_text", "s.mesh"),
    _tets("medit_binary", "s.meshb"),
    _tets("nastran", "s.bdf"),
    _tets("netgen", "s.vol"),
    _tets("permas", "s.dato"),
    _tets("su2", "s.su2"),
    _tets("tecplot", "s.tec"),
    _tets("tetgen_ele", "s.ele"),
    _tets("tetgen_node", "s.node"),
    _tets("ugrid", "s.ugrid"),
    _tets("ugrid_binary", "s.b8.ugrid"),
    _tets("vtk42_text", "s.vtk", file_format="vtk42", binary=False),
    _tets("vtk42_binary", "s.vtk", file_format="vtk42", binary=True),
    _tets("vtk51_text", "s.vtk", file_format="vtk", binary=False),
    _tets("vtk51_binary", "s.vtk", file_format="vtk", binary=True),
    _tets("vtu_text", "s.vtu", binary=False),
    _tets("vtu_binary", "s.vtu", binary=True),
    _tets("xdmf", "s.xdmf"),
    _surface("obj", "s.obj"),
    _surface("off", "s.off"),
    _surface("ply_text", "s.ply", encoding="ascii"),
    _surface("ply_binary", "s.ply", encoding="binary"),
    _surface("stl_text", "s.stl", file_type="stl_ascii"),
    _surface("stl_binary", "s.stl", file_type="stl"),
)


def make_body() -> TetMesh:
    """A cube of 0.2 m in tets of equal size."""
    side = CELLS + 1
    points = np.array(list(itertools.product(np.linspace(0.0, 0.2, side), repeat=3)))
    place = np.array([side * side, side, 1])
    tets = []
    for corner in itertools.product(range(CELLS), repeat=3):
        for order in itertools.permutations(range(3)):
            steps = np.cumsum([0, *(place[axis] for axis in order)])
            tets.append(place @ np.array(corner) + steps)
    return TetMesh.from_arrays(points, np.array(tets))


def write_body(kind: Kind, folder: Path) -> dict[str, bytes]:
    """Write the body into a new folder; the bytes of each file by its name."""
    folder.mkdir(parents=True)
    body = make_body()
    path = folder / kind.file
    with contextlib.redirect_stdout(io.StringIO()), contextlib.redirect_stderr(io.StringIO()):
        if kind.surface:
            skin = trimesh.Trimesh(body.points, body.surface, process=True)
            skin.export(path, **dict(kind.options))
        elif path.suffix == ".xdmf":
            path.write_text(_xdmf(body))
        else:
            meshio.Mesh(body.points, [("tetra", body.tets)]).write(path, **kind.options)
    for entry in folder.iterdir():
        # some of meshio's writers print NumPy's numbers as NumPy 2 shows them
        entry.write_bytes(re.sub(rb"np\.\w+\(([^()]*)\)", rb"\1", entry.read_bytes()))
    return {entry.name: entry.read_bytes() for entry in folder.iterdir()}


def _xdmf(body: TetMesh) -> str:
    """The body as XDMF with its numbers in the text, which meshio writes with h5py alone."""
    points = "\n".join(" ".join(map(repr, row)) for row in body.points.tolist())
    tets = "\n".join(" ".join(map(str, row)) for row in body.tets.tolist())
    return f"""<Xdmf Version="3.0"><Domain><Grid Name="Grid">
<Geometry GeometryType="XYZ">
<DataItem DataType="Float" Dimensions="{len(body.points)} 3" Format="XML" Precision="8">
{points}
</DataItem></Geometry>
<Topology TopologyType="Tetrahedron" NumberOfElements="{len(body.tets)}">
<DataItem DataType="Int" Dimensions="{len(body.tets)} 4" Format="XML" Precision="8">
{tets}
</DataItem></Topology>
</Grid></Domain></Xdmf>
"""
