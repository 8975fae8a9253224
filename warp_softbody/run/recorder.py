"""A `Recorder` keeps what every step of a run did, as NumPy arrays."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt

from warp_softbody.atomic_files import replacing
from warp_softbody.errors import InputError, OutputError
from warp_softbody.inputs import checks, input_kinds
from warp_softbody.run.plan_plots import plan_sheets
from warp_softbody.run.plot_tables import Plot, plot_tables
from warp_softbody.run.plots import check_plots, write_plots
from warp_softbody.run.recorded_step import StepMeter
from warp_softbody.run.simulation import Simulation
from warp_softbody.run.step_record import StepRecord
from warp_softbody.world.frame import ContactSample

Array = npt.NDArray[Any]

_CONTACTS = {
    "node": ("nodes", np.int32, ()),
    "body": ("bodies", np.int32, ()),
    "partner": ("partners", np.int32, ()),
    "mode": ("modes", np.int32, ()),
    "point": ("points", np.float64, (3,)),
    "force": ("forces", np.float64, (3,)),
}
"""Fields of `ContactSample` by what they are called here, their types and the shape of a row."""


class Recorder:
    """Keeps what every step from now on does: `recorder = Recorder(simulation)`, then run.

    It holds, by name, for k steps of b bodies with s muscle segments:

    - ``time`` (k,) s, at which the step ended; steps that a sleeping scene leaves out are missing.
    - ``centre_of_mass`` (k, b, 3) m, ``momentum`` N s, and ``angular_momentum`` N m s about it.
    - ``contact_force`` (k, b, 3) N on each body; ``sticking``, ``sliding`` (k, b) its contacts.
    - ``activations`` (k, s), l_d / l_0.
    - ``energy/kinetic``, ``energy/potential`` of weight, ``energy/elastic``, and
      ``energy/muscles`` of implicit muscles, (k, b) J.
    - ``objective/planned`` (k,), what a plan expected to be left of its goals and to spend on
      activations; ``objective/reached``, what the step came to; ``objective/NAME``, its parts;
      NaN in steps without them.
    - ``plan/momentum`` (k, 3) N s and ``plan/angular_momentum`` N m s that a plan expected of the
      character; ``plan/contact_share`` (k,) of its weight that contact was to bear in the step, and
      ``plan/contact_share_reached``; ``plan/momentum_miss`` of m g dt, ``plan/feet_miss`` of
      sqrt(g L) and ``plan/cost_miss`` of the larger cost, as in `PlanOutcome`; NaN in steps without
      a plan.
    - ``qps``, ``cg_iterations``, ``contact_passes`` (k,).
    - ``milliseconds/PART`` (k,) for each part of a step, measured by the clock.
    - ``contacts/step`` (c,), the number of the step here, ``contacts/node``, ``body``, ``partner``
      (the ground is -1), ``mode`` (`ContactMode`), ``point`` (c, 3) m and ``force`` (c, 3) N of all
      contacts one after the other.

    It measures each step in NumPy, which takes some milliseconds.
    """

    def __init__(self, simulation: Simulation) -> None:
        """Observe a simulation from its next step on."""
        checks.instance("simulation of a Recorder", simulation, Simulation)
        self._meter = StepMeter(simulation.model)
        self._model = simulation.model
        self._steps: list[dict[str, Array]] = []
        self._contacts: list[ContactSample] = []
        simulation.observe(self._note)

    def __len__(self) -> int:
        """Number of steps recorded."""
        return len(self._steps)

    @property
    def body_names(self) -> tuple[str, ...]:
        """Names of the bodies, in the order of the arrays."""
        return tuple(part.name for part in self._model.scene.parts)

    def __getitem__(self, name: str) -> Array:
        """One of the arrays.

        Raises:
            InputError: there is none of that name.
        """
        arrays = self.arrays()
        if not isinstance(name, str) or name not in arrays:
            known = ", ".join(arrays) or "nothing yet, as no step was taken"
            raise InputError(f"a Recorder has no array {checks.shown(name)}; it has: {known}")
        return arrays[name]

    def arrays(self) -> dict[str, Array]:
        """All arrays by name, copied; none before the first step."""
        if not self._steps:
            return {}
        names = dict.fromkeys(name for step in self._steps for name in step)
        found = {name: self._series(name) for name in names}
        counts = [len(contacts.points) for contacts in self._contacts]
        found["contacts/step"] = np.repeat(np.arange(len(counts), dtype=np.int32), counts)
        for name, (field, kind, row) in _CONTACTS.items():
            rows = [getattr(contacts, field) for contacts in self._contacts]
            found[f"contacts/{name}"] = np.concatenate([np.zeros((0, *row)), *rows]).astype(kind)
        return found

    def save(self, path: str | Path) -> Path:
        """Write all arrays, and ``body_names``, as an .npz file, in one step; returns its path.

        Raises:
            InputError: no step was recorded, or the name does not end in .npz.
            OutputError: the file cannot be written.
        """
        target = input_kinds.path("path of Recorder.save", path).expanduser().absolute()
        if target.suffix.lower() != ".npz":
            raise InputError(f"path of Recorder.save must end in .npz, got {str(path)!r}")
        arrays: dict[str, Any] = {"body_names": np.array(self.body_names), **self._recorded()}
        try:
            with replacing(target) as beside:
                np.savez_compressed(beside, **arrays)
        except (OSError, ValueError) as error:
            cause = getattr(error, "strerror", None) or error
            raise OutputError(f"{str(path)!r} could not be written: {cause}") from error
        return target

    def plot(self, folder: str | Path) -> tuple[Path, ...]:
        """Write plots of all arrays as PNG, and their numbers as CSV; returns the files.

        Args:
            folder: is made where there is none; files of the same names are replaced.

        Raises:
            InputError: no step was recorded.
            MissingExtraError: Matplotlib is not installed.
            OutputError: a file cannot be written.
        """
        target = check_plots(folder)
        arrays = self._recorded()
        plots: list[Plot] = [*plot_tables(arrays, self.body_names), *plan_sheets(arrays)]
        return write_plots(plots, target)

    def _recorded(self) -> dict[str, Array]:
        if not self._steps:
            raise InputError("a Recorder has nothing to write: no step was taken since it was made")
        return self.arrays()

    def _note(self, step: StepRecord) -> None:
        numbers, contacts = self._meter.measure(step)
        self._steps.append(numbers)
        self._contacts.append(contacts)

    def _series(self, name: str) -> Array:
        """One number or array a step; NaN where a step has none."""
        rows = [step.get(name) for step in self._steps]
        first = next(row for row in rows if row is not None)
        none = np.full(np.shape(first), np.nan)
        return np.stack([np.asarray(none if row is None else row) for row in rows])
