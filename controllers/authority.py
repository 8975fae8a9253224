"""What muscles can do to linear functions of the next velocities, contact given: small matrices."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from warp_softbody.arrays import FloatArray
from warp_softbody.contact_mode import ContactMode
from warp_softbody.controllers.step_problem import activation_bounds
from warp_softbody.engine.reduced_dynamics import Maps

NOISE = 1e-6
"""Relative size below which a response of the contacts counts as zero: they are redundant there."""


class Response(NamedTuple):
    """How r rows of the next velocities depend on the activations a (s,): ``start + by_segment a``.

    Attributes:
        start: (r,) at activations of zero.
        by_segment: (r, s).
    """

    start: FloatArray
    by_segment: FloatArray

    def range(self, maps: Maps) -> tuple[FloatArray, FloatArray]:
        """Least and greatest value (r,) of each row by itself, over all activations."""
        ends = np.stack([self.by_segment * bound for bound in activation_bounds(maps)])
        low, high = ends.min(axis=0).sum(axis=1), ends.max(axis=0).sum(axis=1)
        return self.start + low, self.start + high


def response(
    maps: Maps,
    count: int,
    modes: tuple[ContactMode, ...],
    gaps: FloatArray,
    impulses: FloatArray | None = None,
) -> Response:
    """The first ``count`` rows of a step's maps while its contacts keep their modes.

    Contacts that stick hold their point, those that slide hold it to the ground without a change of
    friction, those that lift do nothing. Their impulses follow from the activations.

    Args:
        maps: of rows of objectives, and then three of each contact: normal and two tangents.
        count: r, rows of the objectives.
        modes: (K,) of the contacts.
        gaps: (K,) m/s, distance from the ground over the time step.
        impulses: (K, 3) N s, of which those along the ground stay where a contact slides; None for
            contacts without friction.
    """
    by_segment = maps.muscle_map * maps.rest_lengths
    start = maps.free_velocity - maps.muscle_map @ maps.lengths
    held, reach = [], []
    slides = [contact for contact, mode in enumerate(modes) if mode is ContactMode.SLIDE]
    if impulses is not None and slides:
        along = [count + 3 * contact + row for contact in slides for row in (1, 2)]
        start = start + maps.compliance[:, along] @ impulses[slides, 1:].ravel()
    for contact, mode in enumerate(modes):
        rows = {ContactMode.LIFT: 0, ContactMode.SLIDE: 1, ContactMode.STICK: 3}[mode]
        held += [count + 3 * contact + row for row in range(rows)]
        reach += [float(gaps[contact]), 0.0, 0.0][:rows]
    if not held:
        return Response(start[:count], by_segment[:count])
    compliance = maps.compliance[np.ix_(held, held)]
    pushes = maps.compliance[:count, held] @ np.linalg.pinv(compliance, rcond=NOISE, hermitian=True)
    return Response(
        start[:count] - pushes @ (start[held] + np.array(reach)),
        by_segment[:count] - pushes @ by_segment[held],
    )
