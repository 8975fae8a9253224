"""Words on a picture: one in each lower corner."""

from __future__ import annotations

import numpy as np

from warp_softbody.stage_exports.pictures.render import Image

_HEIGHT, _AIR = 0.055, 0.03
"""Of the letters and of the air around them, as shares of the picture's height."""

_INK = (45, 50, 58)


def captioned(image: Image, left: str, right: str) -> Image:
    """The picture (h, w, 3) with words in its lower left and right corner."""
    from PIL import Image as Pictures
    from PIL import ImageDraw, ImageFont

    picture = Pictures.fromarray(image)
    height, width, _ = image.shape
    font = ImageFont.load_default(max(8.0, _HEIGHT * height))
    pen = ImageDraw.Draw(picture)
    air = _AIR * height
    pen.text((air, height - air), left, _INK, font, anchor="ls")
    pen.text((width - air, height - air), right, _INK, font, anchor="rs")
    return np.asarray(picture)
