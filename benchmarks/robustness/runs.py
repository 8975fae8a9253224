"""One run of a scene in a variation, measured from its stage, and what is kept of it."""

from __future__ import annotations

import json
import tempfile
from collections.abc import Mapping
from dataclasses import asdict, dataclass
from pathlib import Path

from benchmarks.motions.criteria import examine
from benchmarks.motions.criterion import RecordedMotion
from benchmarks.robustness.variations import VARIATIONS
from warp_softbody.errors import NotFiniteError
from warp_softbody.run.simulation import Simulation
from warp_softbody.run.warp_session import warp_engine
from warp_softbody.scenes import ScenePlan
from warp_softbody.stage_exports import StageWriter

FPS = 60.0


@dataclass(frozen=True, kw_only=True)
class VariationOutcome:
    """What came of a run.

    Attributes:
        scene: its name.
        variation: name of the variation.
        own: the scene's own number, as text.
        failures: every criterion that is missed, with its number.
        values: the number of every criterion.
    """

    scene: str
    variation: str
    own: str
    failures: tuple[str, ...]
    values: Mapping[str, float]

    def __str__(self) -> str:
        """A cell of the table: the own number, and what fails."""
        missed = [failure for failure in self.failures if not failure.endswith(self.own)]
        own = f"**{self.own}**" if len(missed) < len(self.failures) else self.own
        return ", ".join([own, *(f"**{failure}**" for failure in missed)])


def run(scene: str, variation: str, meshes: Path, seconds: float | None = None) -> VariationOutcome:
    """Run a scene in a variation for its own or another length, and measure its stage."""
    plan = VARIATIONS[variation].plan(scene, meshes)
    with tempfile.TemporaryDirectory() as folder:
        stage = Path(folder) / "motion.usdc"
        with warp_engine("cpu", on_compile=lambda: None):
            broken = _record(plan, stage, seconds or plan.seconds)
        if broken is not None:
            return VariationOutcome(
                scene=scene, variation=variation, own="-", failures=(broken,), values={}
            )
        findings = examine(scene, RecordedMotion.read(stage, plan.scene.character))
    return VariationOutcome(
        scene=scene,
        variation=variation,
        own=findings[0].criterion.text(findings[0].value),
        failures=tuple(str(finding) for finding in findings if not finding.holds),
        values={finding.criterion.name: finding.value for finding in findings},
    )


def _record(plan: ScenePlan, stage: Path, seconds: float) -> str | None:
    """Write the stage; what broke the run off, if anything did."""
    simulation = Simulation(plan.scene, plan.controller, time_step=plan.time_step, fps=FPS)
    with StageWriter(stage, plan.scene, fps=FPS) as writer:
        try:
            for frame in simulation.run(seconds):
                writer.write(frame)
        except NotFiniteError as error:
            return str(error)
    return None


class VariationJournal:
    """A file of JSON lines, one an outcome; a line that was torn is passed over."""

    def __init__(self, path: Path | None) -> None:
        """Read what there is; None keeps nothing."""
        self._path = path
        self.outcomes: dict[tuple[str, str], VariationOutcome] = {}
        if path is not None and path.is_file():
            for line in path.read_text(encoding="utf-8").splitlines():
                self._read(line)

    def _read(self, line: str) -> None:
        try:
            values = json.loads(line)
            values["failures"] = tuple(values["failures"])
            self._keep(VariationOutcome(**values))
        except (ValueError, KeyError, TypeError):
            return

    def add(self, outcome: VariationOutcome) -> None:
        """Keep an outcome, on disk at once."""
        self._keep(outcome)
        if self._path is not None:
            with self._path.open("a", encoding="utf-8") as file:
                file.write(json.dumps(asdict(outcome)) + "\n")

    def _keep(self, outcome: VariationOutcome) -> None:
        self.outcomes[outcome.scene, outcome.variation] = outcome
