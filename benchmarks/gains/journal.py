"""The file in which runs of a search are kept, so that a search that was stopped goes on."""

from __future__ import annotations

import hashlib
import json
from collections.abc import Mapping
from dataclasses import asdict
from pathlib import Path
from typing import Any

from benchmarks.gains.trials import Trial
from benchmarks.robustness.outcomes import fingerprint
from benchmarks.robustness.variation import Variation
from warp_softbody.teaching.json_lines import JsonLines


def key(scene: str, gains: Mapping[str, float], member: Variation, seconds: float | None) -> str:
    """The same for the same run by the same program."""
    values = [scene, dict(gains), member.to_dict(), seconds, fingerprint()]
    return hashlib.sha256(json.dumps(values, sort_keys=True).encode()).hexdigest()[:16]


class TrialJournal:
    """A file of JSON lines, one a run; a line that was torn is passed over."""

    def __init__(self, path: Path | None) -> None:
        """Read what there is; None keeps nothing."""
        self._file = JsonLines(path)
        self._trials: dict[str, Trial] = {}
        for found in self._file.records:
            self._take(found)

    def _take(self, found: Mapping[str, Any]) -> None:
        try:
            self._trials[found["key"]] = Trial(values=found["values"], lasted=found["lasted"])
        except (KeyError, TypeError):
            return

    def of(self, name: str) -> Trial | None:
        """What is known of the run with this key."""
        return self._trials.get(name)

    def add(self, name: str, member: str, gains: Mapping[str, float], trial: Trial) -> None:
        """Keep a run, on disk at once and in one piece."""
        self._trials[name] = trial
        self._file.add({"key": name, "member": member, "gains": dict(gains), **asdict(trial)})
