"""What of the program is installed, by the metadata of its package."""

from __future__ import annotations

import re
from collections import defaultdict
from importlib import metadata

from warp_softbody.errors import InputError

PACKAGE = "warp-softbody"

_NAME = re.compile(r"[A-Za-z0-9._-]+")
_EXTRA = re.compile(r"""extra\s*==\s*['"]([^'"]+)['"]""")

USERS = ("view", "charts", "glb", "learn", "tetgen")
"""Extras for what a user does; the others are for work on the program itself."""


def needed() -> dict[str, str | None]:
    """Versions of the packages that the program cannot do without, by name; None for a missing one.

    Raises:
        InputError: the program runs from a folder without being installed.
    """
    return {name: _version(name) for name in _requirements()[""]}


def extras() -> dict[str, list[str]]:
    """What is missing of each extra for users, by its name.

    Raises:
        InputError: the program runs from a folder without being installed.
    """
    asked = _requirements()
    return {
        extra: [name for name in asked[extra] if _version(name) is None]
        for extra in USERS
        if extra in asked
    }


def _requirements() -> dict[str, list[str]]:
    """Names of packages by extra; those that are always needed under an empty one."""
    try:
        lines = metadata.requires(PACKAGE) or []
    except metadata.PackageNotFoundError as error:
        raise InputError(
            f"{PACKAGE} is not installed here, it runs from a folder: pip install -e that folder"
        ) from error
    found: dict[str, list[str]] = defaultdict(list)
    for line in lines:
        name, extra = _NAME.match(line), _EXTRA.search(line)
        # those for other versions of Python have no part here
        if name is None or "python_version" in line:
            continue
        found[extra.group(1) if extra else ""].append(name.group())
    return found


def _version(name: str) -> str | None:
    try:
        return metadata.version(name)
    except metadata.PackageNotFoundError:
        return None
