"""Where tuned settings are kept: those that ship with the package, and the user's own.

The user's are in ``warp-softbody/tuned.json`` under ``$XDG_CONFIG_HOME``, or ``~/.config``.
"""

from __future__ import annotations

import json
import os
from collections.abc import Mapping
from pathlib import Path

from warp_softbody.accuracy.analysis.tuned_checks import checked
from warp_softbody.accuracy.analysis.tuning import Tuned
from warp_softbody.accuracy.cases.table import case_of
from warp_softbody.atomic_files import folder_lock, replace_text, require_makeable
from warp_softbody.errors import InputError, OutputError

SHIPPED = Path(__file__).with_name("tuned.json")


def own_file() -> Path:
    """That of the user."""
    base = os.environ.get("XDG_CONFIG_HOME") or Path.home() / ".config"
    return Path(base) / "warp-softbody" / "tuned.json"


def save(tuned: Tuned, path: Path) -> None:
    """Add to a file, in place of what it has for the same scene and bound.

    Raises:
        InputError: the file there holds something else.
        OutputError: the file cannot be written.
    """
    try:
        path.parent.mkdir(parents=True, exist_ok=True)
        with folder_lock(path.parent):
            kept = [one for one in load(path) if _key(one) != _key(tuned)]
            every = sorted([*kept, tuned], key=_key)
            text = json.dumps([one.to_dict() for one in every], indent=1) + "\n"
            replace_text(path, text)
    except OSError as error:
        raise _unwritten(path, error) from error


def require_storable(path: Path) -> None:
    """Refuse a file before a sweep is made for it.

    Raises:
        InputError: the file there holds something else.
        OutputError: it could not be written.
    """
    load(path)
    try:
        require_makeable(path.absolute().parent)
    except OSError as error:
        raise _unwritten(path, error) from error


def _unwritten(path: Path, error: OSError) -> OutputError:
    return OutputError(f"cannot write {str(path)!r}: {error.strerror or error}")


def load(path: Path) -> list[Tuned]:
    """All of a file; none where it does not exist.

    Raises:
        InputError: the file does not hold tuned settings.
    """
    if not os.path.lexists(path):
        return []
    try:
        stored = json.loads(path.read_bytes())
        if not isinstance(stored, list):
            raise InputError("it is no list")
        return [checked(values, f"entry {number}") for number, values in enumerate(stored)]
    except (OSError, ValueError, RecursionError) as error:
        cause = error.strerror if isinstance(error, OSError) else error
        raise InputError(f"{str(path)!r} does not hold tuned settings: {cause}") from error


def _key(tuned: Tuned) -> tuple[str, list[tuple[str, float]], float]:
    return tuned.scene, sorted(tuned.given.items()), tuned.bound


def find(scene: str, bound: float, given: Mapping[str, float] | None = None) -> Tuned:
    """The cheapest stored settings of a scene whose bound is the one asked for or a tighter one.

    Those tuned with the same settings of the scene, ``given``, come first, then those of its chart;
    the user's own come before the shipped ones for the same bound.

    Raises:
        InputError: there are none.
    """
    own = dict(case_of(scene).given)
    stored = [t for path in (SHIPPED, own_file()) for t in load(path) if t.scene == scene]
    same = [t for t in stored if dict(t.given) == {**own, **(given or {})}]
    exact = any(t.bound <= bound * (1.0 + 1e-9) for t in same)
    chosen = same if exact else [t for t in stored if dict(t.given) == own]
    every = {t.bound: t for t in chosen}
    fit = [tuned for tuned in every.values() if tuned.bound <= bound * (1.0 + 1e-9)]
    if not fit:
        known = ", ".join(f"{100.0 * kept:g}%" for kept in sorted(every)) or "none"
        raise InputError(
            f"there are no stored settings of {scene!r} for an error of {100.0 * bound:g}% "
            f"(stored: {known}); `warp-softbody tune {scene} --error {100.0 * bound:g}%` makes them"
        )
    return min(fit, key=lambda tuned: tuned.cost)
