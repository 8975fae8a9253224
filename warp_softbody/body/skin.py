"""A `Skin` is a surface to look at, with texture and materials, that a body's tets carry along."""

from __future__ import annotations

import warnings
from collections.abc import Callable
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np
import numpy.typing as npt

from warp_softbody.arrays import FloatArray
from warp_softbody.body.mesh_formats.contents import ReadingFailed
from warp_softbody.body.skin_formats.contents import SkinContents, welded
from warp_softbody.body.skin_formats.glb_skin import read_glb_skin
from warp_softbody.body.skin_formats.obj_skin import read_obj_skin
from warp_softbody.body.skin_formats.ply_skin import read_ply_skin
from warp_softbody.errors import InputError, MeshError, MeshWarning
from warp_softbody.inputs import array_checks, checks, input_kinds
from warp_softbody.inputs.records import FrozenValue

IntArray = npt.NDArray[np.int32]

READERS: dict[str, Callable[[Path], SkinContents]] = {
    ".obj": read_obj_skin,
    ".ply": read_ply_skin,
    ".glb": read_glb_skin,
}
USD = (".usd", ".usda", ".usdc", ".usdz")

PICTURES = {b"\x89PNG": ".png", b"\xff\xd8\xff": ".jpg"}
"""First bytes of the kinds of pictures that textures may be, and the ends of their names."""


@dataclass(frozen=True, kw_only=True, eq=False, repr=False)
class SkinMaterial(FrozenValue):
    """How a part of a skin looks.

    Attributes:
        name: of the material.
        color: linear RGB in 0..1; a texture stands in its place.
        roughness: 0 like a mirror, 1 like chalk.
        opacity: 1 where nothing shines through.
        texture: a PNG or JPEG file's bytes; none where it is empty.
    """

    name: str = "skin"
    color: tuple[float, float, float] = (0.8, 0.8, 0.8)
    roughness: float = 0.5
    opacity: float = 1.0
    texture: bytes = b""

    def __post_init__(self) -> None:
        """Refuse numbers out of their range, and a texture of another kind."""
        checks.keep(
            self,
            name=input_kinds.name("SkinMaterial.name", self.name),
            color=input_kinds.color("SkinMaterial.color", self.color),
            roughness=checks.number("SkinMaterial.roughness", self.roughness, low=0.0, high=1.0),
            opacity=checks.number("SkinMaterial.opacity", self.opacity, low=0.0, high=1.0),
        )
        if not isinstance(self.texture, bytes) or (self.texture and not self.texture_ending):
            wanted = "the bytes of a PNG or JPEG file, or none"
            checks.refuse("SkinMaterial.texture", wanted, self.texture)

    @property
    def texture_ending(self) -> str:
        """``.png`` or ``.jpg``; empty without a texture."""
        known = (name for first, name in PICTURES.items() if self.texture.startswith(first))
        return next(known, "")


@dataclass(frozen=True, kw_only=True, eq=False, repr=False)
class Skin(FrozenValue):
    """A surface of triangles in the rest pose of a body.

    Each of its points moves with the tet that it lies in, or that is nearest to it. Pictures and
    stages show it in place of the tets' own surface; contact is that of the tets.

    Attributes:
        points: (k, 3) m.
        faces: (f, 3) int32 of them, outward.
        texture_points: (t, 2) places in the texture, u to the right, v upwards; (0, 2) for none.
        texture_faces: (f, 3) int32 of them, at the corners of the faces; (0, 3) for none.
        materials: at least one; by default one.
        face_materials: (f,) int32, which of them each face has; by default the first.
    """

    points: FloatArray
    faces: IntArray
    texture_points: FloatArray = field(default_factory=lambda: np.zeros((0, 2)))
    texture_faces: IntArray = field(default_factory=lambda: np.zeros((0, 3), dtype=np.int32))
    materials: tuple[SkinMaterial, ...] = (SkinMaterial(),)
    face_materials: IntArray = field(default_factory=lambda: np.zeros(0, dtype=np.int32))

    def __post_init__(self) -> None:
        """Check that all indices are some of what is there."""
        points = array_checks.array("Skin.points", self.points, (None, 3), unit="m")
        texture = array_checks.array("Skin.texture_points", self.texture_points, (None, 2))
        faces = _indices("Skin.faces", self.faces, (None, 3), len(points))
        if not len(points) or not len(faces):
            raise InputError("Skin.points and Skin.faces must not be empty")
        given = array_checks.array("Skin.texture_faces", self.texture_faces, (None, 3))
        rows = len(faces) if len(given) else 0
        corners = _indices("Skin.texture_faces", given, (rows, 3), len(texture))
        materials = checks.items("Skin.materials", self.materials, SkinMaterial)
        if not materials:
            raise InputError("Skin.materials must hold a SkinMaterial at least")
        chosen = array_checks.array("Skin.face_materials", self.face_materials, (None,))
        if not len(chosen):
            chosen = np.zeros(len(faces))
        owners = _indices("Skin.face_materials", chosen, (len(faces),), len(materials))
        checks.keep(
            self,
            points=_frozen(points),
            faces=_frozen(faces),
            texture_points=_frozen(texture),
            texture_faces=_frozen(corners),
            materials=materials,
            face_materials=_frozen(owners),
        )

    @property
    def textured(self) -> bool:
        """Whether its corners have places in a texture."""
        return len(self.texture_faces) > 0

    @classmethod
    def read(cls, path: str | Path) -> Skin:
        """Read an .obj with its materials and pictures, a .ply, or a .glb.

        `stage_exports.read_skin` reads these and USD files too. Points at one place become one. A
        `MeshWarning` tells what was left out.

        Raises:
            InputError: the path is no path.
            MeshError: the file is missing, of another kind or damaged.
        """
        source = input_kinds.path("path of Skin.read", path)
        suffix = source.suffix.lower()
        if suffix in USD:
            raise MeshError(f"{source}: USD files are read by stage_exports.read_skin")
        if suffix not in READERS:
            known = ", ".join(READERS)
            raise MeshError(f"{source}: a skin is read from {known}, not from {suffix!r}")
        try:
            contents = READERS[suffix](source)
        except OSError as error:
            raise MeshError(f"{source}: cannot be read: {error.strerror or error}") from error
        except (ValueError, ReadingFailed, LookupError, MemoryError, OverflowError) as error:
            cause = " ".join(str(error).split())[:200] or type(error).__name__
            raise MeshError(f"{source}: cannot be read as a {suffix} skin: {cause}") from error
        return cls.of_contents(source, contents)

    @classmethod
    def of_contents(cls, source: Path, contents: SkinContents) -> Skin:
        """The skin that a reader found in a file."""
        found = welded(contents)
        for note in found.notes:
            warnings.warn(f"{source}: {note}", MeshWarning, stacklevel=3)
        try:
            return cls(
                points=found.points,
                faces=found.faces.astype(np.int32),
                texture_points=found.texture_points,
                texture_faces=found.texture_faces.astype(np.int32),
                materials=tuple(SkinMaterial(**one) for one in found.materials),
                face_materials=found.face_materials.astype(np.int32),
            )
        except InputError as error:
            raise MeshError(f"{source}: {error}") from error


def _indices(label: str, value: object, shape: tuple[int | None, ...], count: int) -> IntArray:
    """Whole numbers from 0 to below a count."""
    array = array_checks.array(label, value, shape)
    wrong = (array < 0) | (array >= count) | (array != np.floor(array))
    if wrong.any():
        raise InputError(
            f"{label} must hold whole numbers from 0 to {count - 1}, but it holds "
            f"{array[wrong][0]:g}"
        )
    return array.astype(np.int32)


def _frozen(array: npt.NDArray[np.generic]) -> npt.NDArray[np.generic]:
    own = np.array(array)
    own.flags.writeable = False
    return own
