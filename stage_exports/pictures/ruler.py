"""A measuring rod on the floor of a picture, along the way that a body goes."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from warp_softbody.arrays import FloatArray
from warp_softbody.stage_exports import palette
from warp_softbody.stage_exports.round_lengths import round_length

_DARK, _BRIGHT = (level / float(np.mean(palette.GROUND)) for level in (0.035, 0.85))
_LONGEST = 0.3
"""Of a band, as a part of the body's diagonal: a picture that follows the body shows a few."""


@dataclass(frozen=True, kw_only=True)
class FloorRuler:
    """Bands of one round length, dark and bright in turn, in the floor's own axes.

    Attributes:
        start: (2,) m, the middle of the end at zero.
        along: (2,) unit vector of the way.
        band: m, length of a band.
        bands: how many.
        half_width: m.
        side: (2,) unit vector away from the body.
    """

    start: FloatArray
    along: FloatArray
    side: FloatArray
    band: float
    bands: int
    half_width: float

    @classmethod
    def beside(
        cls, way: FloatArray, points: FloatArray, towards: FloatArray, size: float
    ) -> FloorRuler | None:
        """A rod beside a body that goes along `way`; None where it hardly moves from its place.

        Args:
            way: (f, 2) m, the body's middle in the pictures, the first one where it starts.
            points: (k, 2) m, all that must not stand on the rod.
            towards: (2,) m, the side on which the rod lies.
            size: diagonal of the body, m.
        """
        gone = way - way[0]
        lengths = np.linalg.norm(gone, axis=1)
        farthest = int(np.argmax(lengths))
        if lengths[farthest] < 0.15 * size:
            return None
        along = gone[farthest] / lengths[farthest]
        side = np.array([-along[1], along[0]])
        side *= 1.0 if side @ towards >= 0.0 else -1.0
        half_width = 0.02 * size
        beside = float(((points - way[0]) @ side).max()) + 4.0 * half_width
        band = round_length(min(float(lengths[farthest]) / 3.0, _LONGEST * size))
        # ahead of the middle there is half a body
        ahead = float(((points - way[0]) @ along).max())
        return cls(
            start=way[0] + beside * side,
            along=along,
            side=side,
            band=band,
            bands=int(np.ceil(ahead / band)),
            half_width=half_width,
        )

    def shade(self, flat: FloatArray, footprint: FloatArray) -> tuple[FloatArray, FloatArray]:
        """How much of the ground (r, 2) m is covered, and how bright the rod is there.

        Args:
            flat: places in the floor's own axes.
            footprint: (r, 2) or (r, 1) m, ground that a pixel covers, over which edges are soft.
        """
        away = flat - self.start
        along = away @ self.along
        across = np.abs(away @ self.side)
        soft = np.maximum(footprint.max(axis=1), 1e-9)
        end = self.bands * self.band
        cover = np.clip((self.half_width - across) / soft + 0.5, 0.0, 1.0)
        cover *= np.clip((end / 2.0 - np.abs(along - end / 2.0)) / soft + 0.5, 0.0, 1.0)
        # how far inside a dark band, every other one; negative outside
        phase = along % (2.0 * self.band)
        inside = self.band / 2.0 - np.abs(phase - self.band / 2.0)
        inside = np.maximum(inside, phase - 2.0 * self.band)
        dark = np.clip(inside / soft + 0.5, 0.0, 1.0)
        return cover, _BRIGHT + dark * (_DARK - _BRIGHT)

    def ticks(self, every: int) -> list[tuple[str, FloatArray]]:
        """Lengths in m at every so many ends of bands, and the places (2,) of their words."""
        first = self.start + 2.5 * self.half_width * self.side
        away = self.along * self.band
        length = self.band * every
        digits = next(n for n in range(12) if abs(round(length, n) - length) < 1e-6 * length)
        return [
            (f"{number * self.band:.{digits}f}", first + number * away)
            for number in range(0, self.bands + 1, every)
        ]
