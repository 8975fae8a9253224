"""Skins of a take as a binary glTF: each moves with its middle and by morph targets.

glTF has y upwards; a node above all turns the bodies there. Morph targets are principal components
of what a skin does around its middle (`components.py`). There are no normals, so viewers shade the
faces flat, which stays true while they move.
"""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt

from warp_softbody.arrays import FloatArray
from warp_softbody.atomic_files import replacing
from warp_softbody.body.skin import SkinMaterial
from warp_softbody.errors import MissingExtraError, OutputError
from warp_softbody.stage_exports.forms.components import components_of
from warp_softbody.stage_exports.forms.textured import Textured
from warp_softbody.stage_exports.usd.reader import Take

TOLERANCE = 2e-4
"""m by which a point may be off, times the body's size in m."""

Z_UP_TO_Y_UP = (-(0.5**0.5), 0.0, 0.0, 0.5**0.5)
"""Quaternion x, y, z, w of a quarter turn about x."""


def write_glb(target: Path, takes: Sequence[Take]) -> None:
    """Write one mesh with its animation a body.

    Raises:
        MissingExtraError: pygltflib is not installed.
        OutputError: the file could not be written.
    """
    made = _Document(_library())
    made.add_bodies(takes)
    try:
        with replacing(target) as path:
            path.write_bytes(made.bytes())
    except OSError as error:
        raise OutputError(
            f"{str(target)!r} could not be written: {error.strerror or error}"
        ) from error


def _library() -> Any:
    try:
        import pygltflib
    except ImportError as error:
        raise MissingExtraError(
            "a .glb needs pygltflib, which is not installed: pip install 'warp-softbody[glb]'"
        ) from error
    return pygltflib


class _Document:
    """A glTF that grows body by body, with one buffer."""

    def __init__(self, library: Any) -> None:
        self._lib = library
        self._gltf = library.GLTF2(
            asset=library.Asset(version="2.0", generator="warp-softbody"),
            scene=0,
            scenes=[library.Scene(nodes=[0])],
            nodes=[library.Node(name="World", rotation=list(Z_UP_TO_Y_UP), children=[])],
        )
        self._data = bytearray()

    def add_bodies(self, takes: Sequence[Take]) -> None:
        """One mesh, node and pair of channels a body, all in one animation."""
        animation = self._lib.Animation(name="take", samplers=[], channels=[])
        times = self._accessor(takes[0].times - takes[0].times[0], "SCALAR", bounds=True)
        for take in takes:
            self._add_body(take, times, animation)
        if len(takes[0]) > 1:
            self._gltf.animations = [animation]

    def bytes(self) -> bytes:
        """The whole file."""
        self._gltf.buffers = [self._lib.Buffer(byteLength=len(self._data))]
        self._gltf.set_binary_blob(bytes(self._data))
        return b"".join(self._gltf.save_to_bytes())

    def _add_body(self, take: Take, times: int, animation: Any) -> None:
        middles = take.skin_points.mean(axis=1)
        size = float(np.ptp(take.skin_rest, axis=0).max())
        parts = components_of(take.skin_points - middles[:, None], TOLERANCE * size)
        weights = parts.weights[0].tolist()
        mesh = self._lib.Mesh(name=take.name, primitives=[], weights=weights)
        shown = Textured.of(take)
        targets = [{"POSITION": self._positions(one[shown.points])} for one in parts.targets]
        attributes = self._lib.Attributes(POSITION=self._positions(parts.base[shown.points]))
        if shown.places is not None:
            attributes.TEXCOORD_0 = self._accessor(shown.places, "VEC2")
        for faces, material in shown.parts:
            mesh.primitives.append(
                self._lib.Primitive(
                    attributes=attributes,
                    indices=self._accessor(faces.reshape(-1), "SCALAR"),
                    material=len(self._gltf.materials),
                    targets=targets,
                )
            )
            self._gltf.materials.append(self._material(take, material))
        node = self._lib.Node(
            name=take.name, mesh=len(self._gltf.meshes), translation=middles[0].tolist()
        )
        self._gltf.meshes.append(mesh)
        number = len(self._gltf.nodes)
        self._gltf.nodes[0].children.append(number)
        self._gltf.nodes.append(node)
        self._animate(animation, number, "translation", times, self._accessor(middles, "VEC3"))
        if weights:
            flat = self._accessor(parts.weights.reshape(-1), "SCALAR")
            self._animate(animation, number, "weights", times, flat)

    def _animate(self, animation: Any, node: int, path: str, times: int, values: int) -> None:
        sampler = self._lib.AnimationSampler(input=times, output=values, interpolation="LINEAR")
        aim = self._lib.AnimationChannelTarget(node=node, path=path)
        channel = self._lib.AnimationChannel(sampler=len(animation.samplers), target=aim)
        animation.samplers.append(sampler)
        animation.channels.append(channel)

    def _material(self, take: Take, given: SkinMaterial | None) -> Any:
        """The body's colour, or a material of its own skin."""
        if given is None:
            given = SkinMaterial(name=take.name, color=take.color, roughness=0.45)
        surface = self._lib.PbrMetallicRoughness(
            baseColorFactor=[*given.color, given.opacity],
            metallicFactor=0.0,
            roughnessFactor=given.roughness,
        )
        if given.texture:
            # the texture stands in the colour's place
            surface.baseColorFactor = [1.0, 1.0, 1.0, given.opacity]
            surface.baseColorTexture = self._lib.TextureInfo(index=self._texture(given))
        blended = "BLEND" if given.opacity < 1.0 else "OPAQUE"
        return self._lib.Material(name=given.name, pbrMetallicRoughness=surface, alphaMode=blended)

    def _texture(self, given: SkinMaterial) -> int:
        kind = "image/png" if given.texture_ending == ".png" else "image/jpeg"
        view = self._lib.BufferView(
            buffer=0, byteOffset=len(self._data), byteLength=len(given.texture)
        )
        # what follows begins at a multiple of four
        self._data += given.texture + bytes(-len(given.texture) % 4)
        image = self._lib.Image(bufferView=len(self._gltf.bufferViews), mimeType=kind)
        self._gltf.bufferViews.append(view)
        self._gltf.textures.append(self._lib.Texture(source=len(self._gltf.images)))
        self._gltf.images.append(image)
        return len(self._gltf.textures) - 1

    def _positions(self, points: FloatArray) -> int:
        return self._accessor(points, "VEC3", bounds=True)

    def _accessor(self, values: npt.NDArray[Any], kind: str, *, bounds: bool = False) -> int:
        """Store an array; whole numbers are indices."""
        whole = values.dtype.kind in "iu"
        stored = np.ascontiguousarray(values, dtype=np.uint32 if whole else np.float32)
        view = self._lib.BufferView(buffer=0, byteOffset=len(self._data), byteLength=stored.nbytes)
        self._data += stored.tobytes()
        rows = stored.reshape(len(stored), -1)
        limits = {
            "min": rows.min(axis=0).tolist(),
            "max": rows.max(axis=0).tolist(),
        }
        accessor = self._lib.Accessor(
            bufferView=len(self._gltf.bufferViews),
            componentType=self._lib.UNSIGNED_INT if whole else self._lib.FLOAT,
            count=len(stored),
            type=kind,
            **(limits if bounds else {}),
        )
        self._gltf.bufferViews.append(view)
        self._gltf.accessors.append(accessor)
        return len(self._gltf.accessors) - 1
