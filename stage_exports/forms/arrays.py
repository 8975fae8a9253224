"""All bodies of a take in one file of NumPy arrays."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np

from warp_softbody.atomic_files import replacing
from warp_softbody.errors import OutputError
from warp_softbody.stage_exports.usd.reader import Take
from warp_softbody.world.frame import ContactSample


def write_arrays(target: Path, takes: Sequence[Take]) -> None:
    """``times`` (f,) s, ``fps``, and for each body arrays whose names begin with its own.

    ``NAME/contact_frames`` (k,) has the frame of each row of ``NAME/contact_points``, ``_modes``,
    ``_forces`` and ``_nodes``.

    Raises:
        OutputError: the file could not be written.
    """
    arrays: dict[str, Any] = {"times": takes[0].times, "fps": np.float64(takes[0].fps)}
    for take in takes:
        arrays |= {f"{take.name}/{name}": array for name, array in _of_body(take).items()}
    try:
        with replacing(target) as path, path.open("wb") as file:
            np.savez_compressed(file, **arrays)
    except OSError as error:
        raise OutputError(
            f"{str(target)!r} could not be written: {error.strerror or error}"
        ) from error


def _of_body(take: Take) -> dict[str, Any]:
    return {
        "rest": take.rest,
        "tets": take.tets,
        "points": take.tet_points,
        "velocities": take.velocities,
        "skin_points": take.skin_points,
        "skin_faces": take.skin_faces,
        "fiber_points": take.fiber_points,
        "activations": take.activations,
        **_contacts(take.contacts),
    }


def _contacts(samples: Sequence[ContactSample]) -> dict[str, Any]:
    """Contacts of all frames, one after the other; nodes where the stage tells them."""
    counts = [len(sample.points) for sample in samples]
    found = {
        "contact_frames": np.repeat(np.arange(len(samples), dtype=np.int32), counts),
        "contact_points": np.concatenate([sample.points for sample in samples]),
        "contact_modes": np.concatenate([sample.modes for sample in samples]),
        "contact_forces": np.concatenate([sample.forces for sample in samples]),
    }
    nodes = np.concatenate([sample.nodes for sample in samples])
    return {**found, "contact_nodes": nodes} if len(nodes) == sum(counts) else found
