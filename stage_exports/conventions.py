"""Every exported stage uses these names; readers and checks look prims up by them."""

from __future__ import annotations

import os
from contextlib import suppress
from pathlib import Path

import numpy as np
import numpy.typing as npt

from warp_softbody.atomic_files import require_writable
from warp_softbody.errors import InputError, OutputError
from warp_softbody.inputs import input_kinds

IntArray = npt.NDArray[np.int32]

WORLD = "/World"
GROUND = f"{WORLD}/Ground"
CAMERA = f"{WORLD}/Camera"
LIGHT = f"{WORLD}/Light"
SKY = f"{WORLD}/Sky"
MATERIALS = f"{WORLD}/Materials"
PHYSICS = f"{WORLD}/Physics"

TRANSLATION = "xformOp:translate"

SKIN = "Skin"
TETS = "Tets"
FIBERS = "Fibers"
CONTACTS = "Contacts"
PATCHES = "Patches"

SURFACE, TEXTURE = "Surface", "Texture"
"""Shaders of a material."""

TEXTURE_PLACES = "primvars:st"
TEXTURE_CORNERS = f"{TEXTURE_PLACES}:indices"

REST = "primvars:rest"
VELOCITY = "primvars:velocity"
DISPLAY_COLOR = "primvars:displayColor"
COLOR_INDICES = f"{DISPLAY_COLOR}:indices"
ACTIVATION = "primvars:activation"
CONTACT_MODE = "primvars:mode"
CONTACT_FORCE = "primvars:force"
CONTACT_NODE = "primvars:node"
CONTACT_PARTNER = "primvars:partner"
CONTACT_PARTNER_NODES = "primvars:partnerNodes"
CONTACT_PARTNER_WEIGHTS = "primvars:partnerWeights"

GROUND_NORMAL = "softbody:normal"
GROUND_OFFSET = "softbody:offset"
GROUND_FRICTION = "softbody:friction"
GROUND_HEIGHTS = "softbody:heights"
GROUND_ROWS = "softbody:rows"
GROUND_ORIGIN = "softbody:origin"
GROUND_SPACING = "softbody:spacing"
FRICTION_FACTORS = "softbody:frictionFactors"
FRICTION_ROWS = "softbody:frictionRows"
FRICTION_ORIGIN = "softbody:frictionOrigin"
FRICTION_SPACING = "softbody:frictionSpacing"

MEANINGS = {
    REST: "m, nodes at rest",
    VELOCITY: "m/s, of the nodes at the time of the frame",
    ACTIVATION: "rest length that each muscle segment pulls to over its own, 1 where it is slack",
    CONTACT_MODE: "0 lifts off, 1 sticks, 2 slides",
    CONTACT_FORCE: "N, on the node, a mean over the step before the frame",
    CONTACT_NODE: "node of the body's Tets that touches; -1 where none is told",
    CONTACT_PARTNER: "number of the body on the other side; -1 for the ground",
    CONTACT_PARTNER_NODES: "nodes on the other side, corners of a triangle or ends of an edge; -1",
    CONTACT_PARTNER_WEIGHTS: "place between the nodes on the other side, adding up to one",
    GROUND_NORMAL: "unit normal of the ground, out of it",
    GROUND_OFFSET: "m, distance of the plane from the origin along its normal",
    GROUND_FRICTION: "Coulomb's coefficient",
    GROUND_HEIGHTS: "m, heights of the field, row by row",
    GROUND_ROWS: "number of rows of heights",
    GROUND_ORIGIN: "m, x and y of the first height",
    GROUND_SPACING: "m, between heights along x and y",
    FRICTION_FACTORS: "on Coulomb's coefficient, by cells seen from above, row by row along x",
    FRICTION_ROWS: "number of rows of factors",
    FRICTION_ORIGIN: "m, x and y where the first cell begins; beyond the last the outermost go on",
    FRICTION_SPACING: "m, of the cells along x and y",
}
"""What the attributes of ours are, as their documentation says."""

METADATA_KEY = "warpSoftbody"
EXTENSIONS = (".usdc", ".usda", ".usd", ".usdz")

# Time codes are frame times in units of 1/fps; rounding hides the last bits of time * fps, so that
# the third frame of a 30 Hz take stands at 3 and not at 3.0000000000000004.
TIME_CODE_DIGITS = 6

_TAKEN = {path.rsplit("/", 1)[1] for path in (GROUND, CAMERA, LIGHT, SKY, MATERIALS, PHYSICS)}


def character_path(name: str) -> str:
    """Path of the character's prim; one sentence when the stage needs that name itself."""
    if name in _TAKEN:
        raise InputError(f"a character cannot be named {name!r}: the stage has a prim of that name")
    return f"{WORLD}/{name}"


def checked_target(
    path: str | Path, *, extensions: tuple[str, ...], overwrite: bool = True
) -> Path:
    """The path of a file that can be written there, or one clear sentence why not."""
    given = input_kinds.path("path of a file to write", path)
    try:
        target = given.expanduser().absolute()
        _check_name(target, extensions)
        _check_place(target, overwrite=overwrite)
        _check_folder(target.parent)
    except OutputError:
        raise
    except _Refused as error:
        raise OutputError(f"cannot write {str(path)!r}: {error}") from None
    except (OSError, ValueError, RuntimeError) as error:
        cause = error.strerror if isinstance(error, OSError) else error
        raise OutputError(f"cannot write {str(path)!r}: {cause or error}") from error
    return target


class _Refused(Exception):
    """Why a target is none, as the end of a sentence."""


def _check_name(target: Path, extensions: tuple[str, ...]) -> None:
    if target.suffix.lower() not in extensions:
        raise _Refused(f"the file name must end in one of {', '.join(extensions)}")
    try:
        str(target).encode()
    except UnicodeEncodeError:
        raise _Refused("the name is not UTF-8") from None
    if "\0" in str(target):
        raise _Refused("the name holds a null character")


def _check_place(target: Path, *, overwrite: bool) -> None:
    # where the name is too long, this says so
    with suppress(FileNotFoundError, NotADirectoryError):
        os.lstat(target)
    if target.is_dir():
        raise _Refused("it is a folder")
    if target.parent.exists() and not target.parent.is_dir():
        raise _Refused(f"{str(target.parent)!r} is a file and no folder")
    if not target.parent.is_dir():
        raise _Refused(f"there is no folder {str(target.parent)!r}")
    if target.exists() and not target.is_file():
        raise _Refused("it is not a regular file")
    if target.exists() and not overwrite:
        raise _Refused("it exists and overwrite is off")


def _check_folder(folder: Path) -> None:
    try:
        require_writable(folder)
    except OSError as error:
        raise OutputError(
            f"cannot write in the folder {str(folder)!r}: {error.strerror or error}"
        ) from error
