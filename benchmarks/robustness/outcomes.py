"""A run that is to be made, what came of it, and the file in which that is kept."""

from __future__ import annotations

import hashlib
import json
import os
from collections.abc import Mapping
from dataclasses import asdict, dataclass
from functools import lru_cache
from pathlib import Path
from typing import Any

import benchmarks
import warp_softbody
from benchmarks.robustness.variation import Variation
from warp_softbody.teaching.json_lines import JsonLines

PROGRAM = Path(warp_softbody.__file__).parent
APART = ("accuracy", "cli", "__pycache__")
"""Folders of the package that no run of a scene enters."""
MEASURES = Path(benchmarks.__file__).parent / "motions"


@dataclass(frozen=True, kw_only=True)
class Cell:
    """A scene in a variation; ``seconds`` is the length of the run, None the scene's own."""

    scene: str
    variation: Variation
    seconds: float | None = None

    @property
    def name(self) -> tuple[str, str]:
        """Row and column of the table."""
        return self.scene, self.variation.name

    @property
    def key(self) -> str:
        """The same for the same run by the same program."""
        values = [self.scene, self.variation.to_dict(), self.seconds, fingerprint()]
        return hashlib.sha256(json.dumps(values, sort_keys=True).encode()).hexdigest()[:16]

    @property
    def cost(self) -> float:
        """By which runs are put in order."""
        return self.variation.cost(self.scene)


@dataclass(frozen=True, kw_only=True)
class VariationOutcome:
    """What came of a run.

    Attributes:
        scene: its name.
        variation: name of the variation.
        own: the scene's own number, as text.
        failures: every criterion that is missed, with its number.
        values: the number of every criterion.
        refused: why the engine does not run this; empty where it does.
        limit: s after which the run was broken off; 0 where it was not.
    """

    scene: str
    variation: str
    own: str
    failures: tuple[str, ...]
    values: Mapping[str, float]
    refused: str = ""
    limit: float = 0.0

    @property
    def holds(self) -> bool:
        """Whether the run was made and all criteria hold."""
        return bool(self.values) and not self.failures

    def __str__(self) -> str:
        """A cell of the table: the own number, and what fails."""
        if self.refused:
            return f"refused: {self.refused}"
        if self.limit:
            return f"longer than {self.limit:g} s"
        missed = [failure for failure in self.failures if not failure.endswith(self.own)]
        own = f"**{self.own}**" if len(missed) < len(self.failures) else self.own
        return ", ".join([own, *(f"**{failure}**" for failure in missed)])


@lru_cache
def fingerprint() -> str:
    """Of all sources and data that a run and its measures hang on."""
    found = hashlib.sha256()
    for root in (PROGRAM, MEASURES):
        for folder, inner, names in sorted(os.walk(root, followlinks=True)):
            inner[:] = sorted(name for name in inner if name not in APART)
            for name in sorted(names):
                path = Path(folder) / name
                found.update(str(path.relative_to(root)).encode() + path.read_bytes())
    return found.hexdigest()


class OutcomeJournal:
    """A file of JSON lines, one an outcome; a line that was torn is passed over."""

    def __init__(self, path: Path | None) -> None:
        """Read what there is; None keeps nothing."""
        self._file = JsonLines(path)
        self._outcomes: dict[str, VariationOutcome] = {}
        for values in self._file.records:
            self._take(values)

    def _take(self, values: dict[str, Any]) -> None:
        try:
            key = values.pop("key")
            values["failures"] = tuple(values["failures"])
            self._outcomes[key] = VariationOutcome(**values)
        except (KeyError, TypeError):
            return

    def of(self, cell: Cell, limit: float | None = None) -> VariationOutcome | None:
        """What is known of a run; a run that was broken off counts where no more time is given."""
        found = self._outcomes.get(cell.key)
        longer = found is not None and found.limit and (limit is None or limit > found.limit)
        return None if longer else found

    def add(self, cell: Cell, outcome: VariationOutcome) -> None:
        """Keep an outcome, on disk at once and in one piece."""
        self._outcomes[cell.key] = outcome
        self._file.add({"key": cell.key, **asdict(outcome)})
