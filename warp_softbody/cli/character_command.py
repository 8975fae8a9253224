"""`warp-softbody character SURFACE -o NAME.char` makes a character of a surface."""

from __future__ import annotations

import argparse
import json
import warnings
from pathlib import Path
from typing import TYPE_CHECKING, Any

from warp_softbody.cli.interruption import held_back
from warp_softbody.cli.output import complain, say
from warp_softbody.errors import MeshWarning

if TYPE_CHECKING:
    from warp_softbody.body.character import Character
    from warp_softbody.body.making.made import Made
    from warp_softbody.run.muscle_authority import Authority


WITH_AXES = (".glb", ".usd", ".usda", ".usdc", ".usdz")
"""Ends of files that say which way is up."""

LYING = 1.4
"""Length over height from which on a body may be one that stands, in a file whose y is up."""


def add_parser(subparsers: argparse._SubParsersAction[argparse.ArgumentParser]) -> None:
    """Register the subcommand; its handler is `run`."""
    parser = subparsers.add_parser(
        "character",
        help="make a character of a surface",
        description="Make a character of a surface (.stl, .obj, .ply, .off, .glb), flawed or not, "
        "or of a tet mesh (.vtu, .msh, ...): tets, regions, muscles along its limbs and a material "
        "that stands. "
        "`warp-softbody run NAME.char` lets it balance.",
    )
    parser.add_argument("surface", metavar="SURFACE", type=Path, help="file of the surface")
    parser.add_argument(
        "-o", "--out", metavar="NAME.char", type=Path, required=True, help="file of the character"
    )
    parser.add_argument("--name", help="name of the character (default: that of the file)")
    size = parser.add_mutually_exclusive_group()
    size.add_argument(
        "--unit",
        choices=("m", "dm", "cm", "mm", "inch", "foot"),
        help="unit of the file's lengths (default: the format's, or m where that is plausible)",
    )
    size.add_argument("--height", metavar="H", type=float, help="height of the character, m")
    for flag, meaning in (("--up", "that is upwards"), ("--forward", "of its look")):
        parser.add_argument(
            flag,
            metavar="AXIS",
            help=f"direction {meaning}: x, y, z or their opposites, as {flag}=-z",
        )
    parser.add_argument(
        "--repair",
        choices=("auto", "none"),
        default="auto",
        help="auto (default) unites parts, closes holes and turns what is inside out",
    )
    parser.add_argument("--tets", metavar="N", type=int, help="about how many (1500)")
    parser.add_argument(
        "--density", metavar="RHO", type=float, default=1000.0, help="kg/m^3 (1000)"
    )
    parser.add_argument("--picture", metavar="F.png", type=Path, help="picture with its muscles")
    parser.add_argument(
        "--authority",
        action="store_true",
        help="tell which way each fibre can move the body as it stands (a step is simulated)",
    )
    parser.add_argument("--json", action="store_true", help="print one JSON object")
    parser.add_argument("--quiet", action="store_true", help="print no summary")
    parser.set_defaults(handler=run)


def run(args: argparse.Namespace) -> int:
    """Make, save and describe the character; return 0.

    Raises:
        SoftBodyError: the surface or a value cannot be used, or a file cannot be written.
    """
    with held_back():
        from warp_softbody import read_usd_surfaces
        from warp_softbody.body.character import Character
        from warp_softbody.body.character_files import EXTENSION
        from warp_softbody.body.making.from_surface import made_from_surface
        from warp_softbody.stage_exports.conventions import checked_target

    # before the work of minutes
    checked_target(args.out, extensions=(EXTENSION,))
    if args.picture is not None:
        checked_target(args.picture, extensions=(".png",))
    read_usd_surfaces()

    with warnings.catch_warnings():
        warnings.simplefilter("always", MeshWarning)
        warnings.showwarning = _show  # type: ignore[assignment]
        made = made_from_surface(
            args.surface,
            name=args.name,
            unit=args.unit,
            height=args.height,
            up=args.up,
            forward=args.forward,
            repair=args.repair,
            tets=args.tets,
            density=args.density,
        )
        character = Character(**made.parts)
    if args.picture is not None:
        _draw(args.picture, character)
    character.save(args.out)
    if args.json:
        facts = {"surface": str(args.surface), "out": str(args.out), **_facts(made)}
        if args.authority:
            facts["authority"] = [
                {
                    "name": own.name,
                    "centre_of_mass": own.centre_of_mass.tolist(),
                    "spin": own.spin.tolist(),
                    "feet": {foot: way.tolist() for foot, way in own.feet.items()},
                }
                for own in _authorities(character)
            ]
        say(json.dumps(facts))
    elif not args.quiet:
        say(_as_text(args, made))
        if args.authority:
            say(_authority_table(character))
    return 0


def _show(message: Warning | str, *_: object) -> None:
    """One line on stderr, as errors have."""
    complain(str(message))


def _draw(path: Path, character: Character) -> None:
    """A picture of the character as it stands, on a floor."""
    import numpy as np

    from warp_softbody.stage_exports import draw_picture
    from warp_softbody.world.frame import Frame
    from warp_softbody.world.ground import Plane
    from warp_softbody.world.scene import Scene
    from warp_softbody.world.standing import standing_contacts

    scene = Scene(character=character, ground=Plane())
    points = np.array(character.mesh.points)
    frame = Frame(
        index=0,
        time=0.0,
        positions=points,
        velocities=np.zeros_like(points),
        activations=np.ones(character.segment_count),
        fiber_points=np.concatenate([fiber.vertices for fiber in character.fibers]),
        contacts=standing_contacts(scene, points),
    )
    draw_picture(path, scene, frame)


def _authorities(character: Character) -> tuple[Authority, ...]:
    from warp_softbody.run.muscle_authority import muscle_authority
    from warp_softbody.run.warp_session import warp_engine

    with warp_engine("cpu", lambda: None):
        return muscle_authority(character)


def _authority_table(character: Character) -> str:
    """What each fibre does to the body, a line each."""
    lines = ["full contraction: centre of mass (g)   spin (m g L)   foot that moves most (g)"]
    for own in _authorities(character):
        foot = max(own.feet, key=lambda name: float(own.feet[name] @ own.feet[name]))
        way, spin, by = (
            " ".join(f"{number:6.2f}" for number in three)
            for three in (own.centre_of_mass, own.spin, own.feet[foot])
        )
        lines.append(f"{own.name:<20} {way}   {spin}   {foot} {by}")
    return "\n".join(lines)


def _facts(made: Made) -> dict[str, Any]:
    """What is told of a character, in SI units."""
    mesh, material = made.mesh, made.material
    return {
        "name": made.name,
        "height": float(mesh.points[:, 2].max()),
        "size": [float(side) for side in mesh.bounds[1] - mesh.bounds[0]],
        "mass": mesh.volume * material.density,
        "nodes": len(mesh.points),
        "tets": len(mesh.tets),
        "young_modulus": material.young_modulus,
        "limbs": [round(limb.length, 4) for limb in made.limbs if limb.ends],
        "feet": [name for name in made.regions if name.startswith("foot_")],
        "fibers": sum(len(group.fibers) for group in made.muscles),
        "segments": sum(group.segment_count for group in made.muscles),
        "repairs": list(made.repairs),
    }


def _as_text(args: argparse.Namespace, made: Made) -> str:
    facts = _facts(made)
    x, y, z = facts["size"]
    limbs = facts["limbs"]
    feet = len(facts["feet"])
    stands = f"stands on {feet} feet" if feet else "stands on one base"
    lengths = ", ".join(f"{length:.2g}" for length in limbs)
    arms = f"{_counted(len(limbs), 'limb')} ({lengths} m)" if limbs else "no limbs"
    return "\n".join(
        (
            f"{facts['name']}: {x:.3g} x {y:.3g} x {z:.3g} m, {facts['mass']:.3g} kg, {stands}",
            f"{facts['tets']} tets, Young's modulus {facts['young_modulus']:.2g} Pa",
            f"{arms}, {_counted(facts['fibers'], 'fibre')} of together "
            f"{_counted(facts['segments'], 'segment')}",
            *_lies(args, y, max(x, y) / z),
            f"character {args.out}",
        )
    )


def _lies(args: argparse.Namespace, y: float, length: float) -> tuple[str, ...]:
    """A line where the file's y may have been meant for up: ``length`` is over the height."""
    if args.up is not None or args.surface.suffix.lower() in WITH_AXES or length < LYING:
        return ()
    return (f"z was taken for up; if it lies and is to stand {y:.3g} m high, give --up y",)


def _counted(count: int, single: str) -> str:
    """A number and what is counted."""
    return f"{count} {single}" if count == 1 else f"{count} {single}s"
