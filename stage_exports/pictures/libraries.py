"""The package that reads and writes pictures, the optional extra `view`."""

from __future__ import annotations

from typing import Any

from warp_softbody.errors import MissingExtraError


def imageio() -> Any:
    """The imageio package, or one sentence on where to get it."""
    try:
        import imageio.v2
    except ImportError as error:
        raise MissingExtraError(
            "pictures need imageio, which is not installed: pip install 'warp-softbody[view]'"
        ) from error
    return imageio.v2
