"""A finished stage becomes a page: the moments of its takes."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from pathlib import Path

import numpy as np
import numpy.typing as npt

from warp_softbody.arrays import FloatArray
from warp_softbody.body.mesh_geometry import lumped_masses, tet_volumes
from warp_softbody.live.measures import CharacterMeasures
from warp_softbody.live.outline import SceneOutline, ShownBody
from warp_softbody.live.scene_view import level_of
from warp_softbody.live.take_page import TakePage
from warp_softbody.live.wire import Moment
from warp_softbody.stage_exports.usd.reader import Take, read_takes
from warp_softbody.world.frame import ContactSample


def stage_page(path: Path) -> bytes:
    """The page of a stage.

    Raises:
        InputError: the file is none, or is damaged.
    """
    takes = read_takes(path)
    measures = take_measures(takes[0])
    page = TakePage(take_outline(takes, path.stem, measures))
    parts = [page.begin()]
    parts += [page.add(moment) for moment in take_moments(takes, measures)]
    return b"".join([*parts, page.end()])


def take_measures(take: Take) -> CharacterMeasures:
    """Measures of a body of which a stage tells neither density nor gravity."""
    masses = lumped_masses(take.tets, np.abs(tet_volumes(take.rest, take.tets)), len(take.rest))
    normal, offset = level_of(take.ground)
    return CharacterMeasures(
        masses / masses.sum(), None, gravity=None, normal=normal, offset=offset
    )


def take_outline(takes: Sequence[Take], name: str, measures: CharacterMeasures) -> SceneOutline:
    """What is told once; the points of a stage's skins are cut along their sharp edges already."""
    segments = sum(take.fiber_points.shape[1] for take in takes)
    bodies, first = [], 0
    for take in takes:
        corners = np.arange(first, first + len(take.skin_rest), dtype=np.int32)
        first += len(corners)
        body = ShownBody(name=take.name, color=take.color, corners=corners, faces=take.skin_faces)
        bodies.append(body)
    return SceneOutline(
        name=name,
        fps=takes[0].fps,
        bodies=tuple(bodies),
        points=np.concatenate([take.skin_points[0] for take in takes]),
        segments=np.arange(2 * segments, dtype=np.int32).reshape(-1, 2),
        fiber_points=2 * segments,
        ground=takes[0].ground,
        numbers=measures.names,
        weight=None,
    )


def take_moments(takes: Sequence[Take], measures: CharacterMeasures) -> Iterator[Moment]:
    """Frame by frame what is shown; the contacts of all bodies, those of the first one marked."""
    own = takes[0]
    for frame, time in enumerate(own.times.tolist()):
        contraction = np.concatenate([1.0 - take.activations[frame] for take in takes])
        measured = measures.of(
            own.tet_points[frame],
            own.velocities[frame],
            1.0 - own.activations[frame],
            own.contacts[frame],
        )
        yield Moment(
            time=time,
            surface=np.concatenate([take.skin_points[frame] for take in takes]),
            fibers=np.concatenate([_ends(take.fiber_points[frame]) for take in takes]),
            contraction=contraction,
            contacts=_joined([take.contacts[frame] for take in takes]),
            patches=own.patches[frame],
            numbers=measured,
        )


def _ends(points: FloatArray) -> FloatArray:
    return points.reshape(-1, 3)


def _joined(samples: Sequence[ContactSample]) -> ContactSample:
    """All contacts, each with the number of its body."""

    def numbers(name: str) -> npt.NDArray[np.int32]:
        return np.concatenate([getattr(sample, name) for sample in samples]).astype(np.int32)

    bodies = [np.full(len(sample.points), body) for body, sample in enumerate(samples)]
    return ContactSample(
        nodes=numbers("nodes"),
        points=np.concatenate([sample.points for sample in samples]),
        modes=numbers("modes"),
        forces=np.concatenate([sample.forces for sample in samples]),
        bodies=np.concatenate(bodies).astype(np.int32),
        partners=numbers("partners"),
    )
