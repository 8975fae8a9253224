"""Skins out of any file that one is known to be in, USD files in a process of their own."""

from __future__ import annotations

from pathlib import Path

from warp_softbody.body.skin import USD, Skin
from warp_softbody.body.skin_formats.contents import SkinContents
from warp_softbody.errors import InputError, MeshError
from warp_softbody.inputs import input_kinds
from warp_softbody.stage_exports.usd.isolation import apart


def read_skin(path: str | Path) -> Skin:
    """Read a skin out of a USD file, or out of what `Skin.read` knows.

    Of a USD file it is all meshes that are drawn, where they are at first, scaled to metres and
    with z upwards, with the colours and textures of their preview surfaces.

    Raises:
        InputError: the path is no path.
        MeshError: the file is missing, of another kind, damaged or without a mesh.
    """
    source = input_kinds.path("path of read_skin", path)
    if source.suffix.lower() not in USD:
        return Skin.read(source)
    try:
        fields = apart("extract_skin", source)
    except InputError as error:
        raise MeshError(str(error)) from error
    return Skin.of_contents(source, SkinContents(*fields))
