"""`warp-softbody mesh IN -o OUT` fills a surface with tets, or checks and converts a tet file."""

from __future__ import annotations

import argparse
import json
import sys
import warnings
from pathlib import Path
from typing import TYPE_CHECKING

from warp_softbody.cli.output import say
from warp_softbody.errors import InputError, MeshWarning

if TYPE_CHECKING:
    from warp_softbody.body.mesh import TetMesh


def add_parser(subparsers: argparse._SubParsersAction[argparse.ArgumentParser]) -> None:
    """Register the subcommand; its handler is `run`."""
    parser = subparsers.add_parser(
        "mesh",
        help="fill a closed surface with tets, or check and convert a tet file",
        description="Fill a closed surface (.stl, .obj, .ply, .off) with tets and compare the "
        "result with it. A tet file is checked and converted.",
    )
    parser.add_argument("input", metavar="IN", type=Path, help="surface or tet file, in metres")
    parser.add_argument(
        "-o", "--output", metavar="OUT", type=Path, required=True, help="tet file, such as body.vtu"
    )
    parser.add_argument(
        "--mesher",
        choices=("ftetwild", "tetgen"),
        help="ftetwild (default) takes flawed surfaces; tetgen keeps the surface exactly",
    )
    parser.add_argument(
        "--size",
        metavar="H",
        type=float,
        help="target edge length in m (default: box diagonal / 10)",
    )
    parser.add_argument("--json", action="store_true", help="print the summary as one JSON object")
    parser.add_argument("--quiet", action="store_true", help="print no summary")
    parser.set_defaults(handler=run)


def run(args: argparse.Namespace) -> int:
    """Make, check and write the mesh, then print a summary; return 0.

    Raises:
        SoftBodyError: the sentence for the user; no output file is left behind.
    """
    from warp_softbody.body.mesh_files import check_writable

    # Meshing may take minutes: a wrong output path is told before, not after.
    check_writable(args.output)
    with warnings.catch_warnings():
        warnings.simplefilter("always", MeshWarning)
        warnings.showwarning = _show  # type: ignore[assignment]
        mesh, surface_volume = _mesh(args)
        mesh.write(args.output)
    if args.json:
        say(_as_json(args, mesh, surface_volume))
    elif not args.quiet:
        say(_as_text(mesh, surface_volume))
    return 0


def _show(message: Warning | str, *_: object) -> None:
    """One line on stderr, as errors have."""
    print(f"warp-softbody: {message}", file=sys.stderr)


def _mesh(args: argparse.Namespace) -> tuple[TetMesh, float | None]:
    """The mesh, and the volume in m^3 that a surface encloses."""
    from warp_softbody.body.meshing.surface import EXTENSIONS

    if args.input.suffix.lower() in EXTENSIONS:
        return _from_surface(args)
    return _from_tets(args), None


def _from_surface(args: argparse.Namespace) -> tuple[TetMesh, float]:
    """Mesh of a surface file, and the volume that the surface encloses, m^3."""
    from warp_softbody.body.mesh import TetMesh
    from warp_softbody.body.meshing import load_surface, tetrahedralize

    surface = load_surface(args.input)
    filled = tetrahedralize(surface, mesher=args.mesher or "ftetwild", size=args.size)
    return TetMesh(filled.points, filled.tets), surface.volume


def _from_tets(args: argparse.Namespace) -> TetMesh:
    """Mesh of a tet file, which no mesher touches."""
    for name in ("mesher", "size"):
        if getattr(args, name) is not None:
            raise InputError(
                f"--{name} is for surfaces, but {args.input} is not one "
                f"(.stl, .obj, .ply, .off); a tet file is only checked and converted"
            )
    from warp_softbody.body.mesh import TetMesh

    return TetMesh.read(args.input)


def _as_text(mesh: TetMesh, surface_volume: float | None) -> str:
    volume = f"volume {mesh.volume:.6g} m^3"
    if surface_volume is not None:
        volume += f" ({mesh.volume / surface_volume - 1.0:+.2%} of the surface's)"
    parts = "1 part" if mesh.part_count == 1 else f"{mesh.part_count} parts"
    return (
        f"{len(mesh.points)} points, {len(mesh.tets)} tets, {parts}\n"
        f"{volume}, smallest dihedral angle {mesh.smallest_dihedral_angle:.1f} degrees"
    )


def _as_json(args: argparse.Namespace, mesh: TetMesh, surface_volume: float | None) -> str:
    return json.dumps(
        {
            "input": str(args.input),
            "output": str(args.output),
            "points": len(mesh.points),
            "tets": len(mesh.tets),
            "parts": mesh.part_count,
            "volume": mesh.volume,
            "surface_volume": surface_volume,
            "smallest_dihedral_angle": mesh.smallest_dihedral_angle,
            "bounds": mesh.bounds.tolist(),
            "regions": {name: len(nodes) for name, nodes in mesh.regions.items()},
        }
    )
