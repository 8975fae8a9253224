"""Packages that only some of the program needs, and where to get them."""

from __future__ import annotations

from importlib.util import find_spec

from warp_softbody.errors import MissingExtraError


def require_package(package: str, what: str, extra: str) -> None:
    """Say early that something cannot be done.

    Args:
        package: as it is imported.
        what: needs it, the sentence's subject in the plural.
        extra: of this package, that installs it.

    Raises:
        MissingExtraError: it is not installed.
    """
    if find_spec(package) is None:
        raise MissingExtraError(
            f"{what} need {package}, which is not installed: pip install 'warp-softbody[{extra}]'"
        )
