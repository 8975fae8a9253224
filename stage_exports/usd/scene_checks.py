"""What a stage cannot hold of a scene is refused before there is a frame to lose."""

from __future__ import annotations

import shutil
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np
from pxr import Sdf, Tf

from warp_softbody.atomic_files import private_folder
from warp_softbody.body.character import Character
from warp_softbody.errors import InputError, OutputError
from warp_softbody.inputs import checks, input_kinds
from warp_softbody.stage_exports.bodies import StagedBody
from warp_softbody.stage_exports.camera import Camera
from warp_softbody.stage_exports.conventions import character_path
from warp_softbody.stage_exports.usd.chunks import USD
from warp_softbody.stage_exports.usd.merging import export, reason
from warp_softbody.stage_exports.usd.physics_names import Profile
from warp_softbody.stage_exports.usd.static_layer import static_layer
from warp_softbody.stage_exports.usd.textures import FOLDER
from warp_softbody.world.scene import Scene

LONGEST = 1000
"""Characters of a name."""


def checked_static_layer(
    scene: Scene,
    bodies: Sequence[StagedBody],
    fps: float,
    metadata: Mapping[str, str | float],
    view: Camera,
    profile: Profile,
    target: Path,
) -> Any:
    """What of a take does not move, as a layer that was written beside the target, as a trial.

    Raises:
        InputError: a part of the scene cannot be stored.
        OutputError: the target's folder has no room for it.
    """
    for character in scene.characters:
        _check_character(character)
    try:
        with USD:
            textures = FOLDER.format(target.stem)
            layer = static_layer(scene, bodies, fps, metadata, view, profile, textures)
    except InputError:
        raise
    except (Tf.ErrorException, TypeError, ValueError, OverflowError) as error:
        raise InputError(f"the scene cannot be stored in a stage: {reason(error)}") from error
    _try(layer, target.parent)
    return layer


def checked_metadata(metadata: Mapping[str, str | float]) -> dict[str, str | float]:
    """Names and values that USD can keep.

    Raises:
        InputError: it cannot keep one of them.
    """
    checked: dict[str, str | float] = {}
    for name, value in input_kinds.mapping("metadata of a StageWriter", metadata).items():
        input_kinds.name("a name in the metadata of a StageWriter", name)
        given = checks.plain(value)
        if isinstance(given, str):
            checked[name] = input_kinds.text(f"metadata {name!r}", given)
            if not _is_text(given):
                checks.refuse(f"metadata {name!r}", "a text without NUL", value)
        elif isinstance(given, bool | float) or (isinstance(given, int) and abs(given) < 2**63):
            checked[name] = given
        else:
            checks.refuse(f"metadata {name!r}", "text or a number of at most 64 bits", value)
    return checked


def _check_character(character: Character) -> None:
    name = character.name
    if len(name) > LONGEST or not _is_text(name) or not Sdf.Path.IsValidIdentifier(name):
        raise InputError(
            f"a character's name must be an identifier of at most {LONGEST} characters, "
            f"got {name[:40]!r} with {len(name)}"
        )
    character_path(name)
    try:
        color = np.array(character.color, dtype=np.float64)
    except (TypeError, ValueError):
        color = np.zeros(0)
    if color.shape != (3,) or not np.isfinite(color.astype(np.float32)).all():
        raise InputError(
            f"character {name!r}: color must be three finite numbers, got {character.color!r}"
        )


def _is_text(text: str) -> bool:
    try:
        text.encode()
    except UnicodeEncodeError:
        return False
    return "\0" not in text


def _try(layer: Any, folder: Path) -> None:
    """Write a layer into a folder and remove it again."""
    try:
        made = private_folder(folder)
        try:
            with USD:
                export(layer, str(made / "trial.usdc"))
        finally:
            shutil.rmtree(made, ignore_errors=True)
    except OSError as error:
        raise OutputError(f"cannot write in the folder {str(folder)!r}: {reason(error)}") from error
