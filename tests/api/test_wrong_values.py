"""Every public name is given values of every wrong kind: it refuses them in one sentence.

The calls are generated from the signatures and their hints; one argument at a time is spoilt.
"""

from __future__ import annotations

import inspect
import warnings
from collections.abc import Callable
from enum import Enum
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import warp_softbody as wsb
from tests.api import samples
from tests.api.wrong_values import EVERY, NOT_FINITE, REFUSED, Awkward, kind_of, label
from warp_softbody import characters, controllers, live, scene_files, scenes, stage_exports
from warp_softbody.errors import SoftBodyError

INFINITE = {("SolverOptions", "time_limit"), ("SolverOptions", "reach"), ("Patch", "area")}
FREE_TEXT = {("Setting", "unit"), ("Setting", "help")}


@pytest.fixture(scope="module")
def every(tmp_path_factory: pytest.TempPathFactory) -> samples.Samples:
    folder = tmp_path_factory.mktemp("wrong")
    return {**samples.engine(folder), **samples.control(), **samples.exports(folder)}


def outcome(call: Callable[..., Any], arguments: dict[str, Any]) -> str | None:
    """None where a call is accepted, else its sentence; any other error is raised."""
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")
            call(**arguments)
    except SoftBodyError as error:
        return str(error)
    return None


def spoilt(every: samples.Samples) -> list[tuple[str, str, str, Any]]:
    """Name, parameter, its hint and a wrong value."""
    found = []
    for name, (call, _) in every.items():
        for parameter in inspect.signature(call).parameters.values():
            hint = str(parameter.annotation)
            enum = inspect.isclass(call) and issubclass(call, Enum)
            if enum and parameter.name != "value":
                continue
            # the look-up of an enumeration is Python's own: it compares, and shows what it refuses
            simple = [v for v in EVERY if not isinstance(v, np.ndarray | Awkward)]
            values = simple if enum else EVERY
            found += [(name, parameter.name, hint, value) for value in values]
    return found


def test_wrong_values_are_one_sentence(
    every: samples.Samples, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    calls = spoilt(every)
    assert len(calls) > 10_000
    wrong = []
    for name, parameter, _, value in calls:
        call, right = every[name]
        try:
            sentence = outcome(call, {**right, parameter: value})
        except Exception as error:
            wrong.append(f"{name}({parameter}={label(value)}): {type(error).__name__}: {error}")
            continue
        if sentence is not None and ("\n" in sentence or not 5 < len(sentence) < 600):
            wrong.append(f"{name}({parameter}={label(value)}): {sentence!r}")
    assert not wrong, f"{len(wrong)} of {len(calls)}:\n" + "\n".join(wrong[:60])


def test_what_cannot_be_right_is_not_accepted(every: samples.Samples) -> None:
    accepted = []
    for name, (call, right) in every.items():
        for parameter in inspect.signature(call).parameters.values():
            place = (name, parameter.name)
            kind = kind_of(str(parameter.annotation))
            if kind is None or place in FREE_TEXT:
                continue
            for value in REFUSED[kind]:
                optional = value is None or (value is True and kind == "bool")
                if optional or (kind == "float" and place in INFINITE):
                    continue
                if outcome(call, {**right, parameter.name: value}) is None:
                    accepted.append(f"{name}({parameter.name}={label(value)}) of the hint {kind}")
    assert not accepted, f"{len(accepted)}:\n" + "\n".join(accepted[:60])


def test_right_values_are_accepted(every: samples.Samples) -> None:
    may_fail = {"TetMesh.read", "QPCC.load", "recover", "QPCCStatus", "StageWriter.write"}
    for name, (call, right) in every.items():
        if name not in may_fail:
            assert outcome(call, right) is None, name


def test_every_public_name_is_tried(every: samples.Samples) -> None:
    tried = {name.split(".")[0] for name in every}
    public = {
        name
        for room in (wsb, controllers, stage_exports, live, scene_files)
        for name in room.__all__
        if callable(getattr(room, name))
    }
    assert public - tried - samples.OUTPUTS == set()


def test_meshing_begins_with_nothing_wrong() -> None:
    surface = characters.letter_i_surface()
    for wrong in EVERY:
        with pytest.raises(SoftBodyError):
            wsb.TetMesh.from_surface(wrong)
        with pytest.raises(SoftBodyError):
            wsb.TetMesh.from_surface(surface, mesher=wrong)
    for wrong in (*REFUSED["float"], *NOT_FINITE, 0.0, -1.0, 10**400):
        with pytest.raises(SoftBodyError):
            wsb.TetMesh.from_surface(surface, size=wrong)


@pytest.mark.parametrize("name", scenes.names())
def test_settings_of_scenes(name: str) -> None:
    recipe = scenes.recipe(name)
    for setting in recipe.settings:
        for value in EVERY:
            try:
                number = setting.parse(value)
            except SoftBodyError:
                continue
            assert setting.low <= number <= setting.high, (setting.name, label(value))
    for wrong in EVERY:
        try:
            recipe.make({wrong: 1.0})
        except (SoftBodyError, TypeError) as error:
            # what has no hash is no key of any dictionary
            assert isinstance(error, SoftBodyError) or "unhashable" in str(error)


def test_names_of_scenes_and_settings_of_no_dictionary() -> None:
    for wrong in EVERY:
        with pytest.raises(SoftBodyError):
            scenes.make(wrong)
        if wrong is not None and not (isinstance(wrong, dict) and not wrong):
            with pytest.raises(SoftBodyError):
                scenes.make("stack", wrong)
