"""Words on a picture: one in each upper corner, and lengths at the bands of a ruler."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from warp_softbody.stage_exports.pictures.render import Image, Renderer

Word = tuple[str, tuple[float, float], str]

_HEIGHT, _AIR = 0.055, 0.03
"""Of the letters and of the air around them, as shares of the picture's height."""

_TICK_HEIGHT, _TICK_ROOM = 0.042, 3.2
"""Of the letters of lengths, and how many such heights they need beside each other."""

_STEPS = (1, 2, 5, 10, 20, 50)

_INK = (18, 20, 24)


def captioned(image: Image, left: str, right: str) -> Image:
    """The picture (h, w, 3) with words in its upper left and right corner."""
    width, air = image.shape[1], _AIR * image.shape[0]
    words = [(left, (air, air), "la"), (right, (width - air, air), "ra")]
    return _written(image, words, _HEIGHT)


def tick_step(renderer: Renderer) -> int:
    """Bands of the ruler from one word to the next, so that words have room in this view."""
    floor = renderer.floor
    assert floor is not None and floor.ruler is not None
    for every in _STEPS:
        ticks = floor.ruler.ticks(every)
        places, _ = renderer.places(floor.lifted(np.array([place for _, place in ticks])))
        near = np.linalg.norm(np.diff(places, axis=0), axis=1)
        if (near > _TICK_ROOM * _TICK_HEIGHT * renderer.height).all():
            return every
    return _STEPS[-1]


def measured(image: Image, renderer: Renderer, step: int) -> Image:
    """The picture with lengths in m beside every so many bands of the ruler on its floor."""
    floor = renderer.floor
    assert floor is not None and floor.ruler is not None
    height, width, _ = image.shape
    ticks = floor.ruler.ticks(step)
    places, depth = renderer.places(floor.lifted(np.array([place for _, place in ticks])))
    room = _TICK_HEIGHT * height
    low, high = (room, room), (width - room, height - room)
    seen = (depth > 0.0) & ((places > low) & (places < high)).all(axis=1)
    words: list[Word] = [
        (ticks[number][0], (float(places[number, 0]), float(places[number, 1])), "mm")
        for number in np.flatnonzero(seen)
    ]
    return _written(image, words, _TICK_HEIGHT)


def _written(image: Image, words: Sequence[Word], share: float) -> Image:
    """Words at places (column, row), in letters of a share of the picture's height."""
    from PIL import Image as Pictures
    from PIL import ImageDraw, ImageFont

    picture = Pictures.fromarray(image)
    font = ImageFont.load_default(max(8.0, share * image.shape[0]))
    pen = ImageDraw.Draw(picture)
    for word, (column, row), anchor in words:
        pen.text((column, row), word, _INK, font, anchor=anchor)
    return np.asarray(picture)
