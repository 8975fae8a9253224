"""What the program says of the machine that it is on, and completions of its commands."""

from __future__ import annotations

import json
from importlib import metadata
from typing import Any

import pytest

from tests.cli.conftest import Call


def test_a_working_installation_is_told_as_such(call: Call) -> None:
    answer = call("doctor", "--json")
    facts = json.loads(answer.out)
    assert answer.code == 0 and facts["works"] and facts["fall_error"] < 1e-5
    assert facts["needed"]["numpy"] == metadata.version("numpy")
    # the tests have these extras
    assert facts["extras"]["view"] == [] and facts["extras"]["charts"] == []
    words = call("doctor").out
    assert "as it should" in words and "MISSING" not in words


def test_what_is_missing_is_named_with_the_command_that_brings_it(
    call: Call, monkeypatch: pytest.MonkeyPatch
) -> None:
    real = metadata.version

    def version(name: str) -> str:
        if name in ("meshio", "embreex"):
            raise metadata.PackageNotFoundError(name)
        return real(name)

    monkeypatch.setattr(metadata, "version", version)
    answer = call("doctor")
    assert answer.code == 2
    assert "MISSING  meshio: pip install meshio" in answer.out
    assert "view: lacks embreex: pip install 'warp-softbody[view]'" in answer.out


def test_a_folder_without_an_installation_is_one_sentence(
    call: Call, monkeypatch: pytest.MonkeyPatch
) -> None:
    def nothing(name: str) -> Any:
        raise metadata.PackageNotFoundError(name)

    monkeypatch.setattr(metadata, "requires", nothing)
    answer = call("doctor")
    assert answer.code == 2 and "is not installed here" in answer.err


@pytest.mark.parametrize("shell", ["bash", "zsh", "tcsh"])
def test_completions_know_commands_and_options(call: Call, shell: str) -> None:
    answer = call("completion", shell)
    assert answer.code == 0
    for word in ("doctor", "convert", "movie"):
        assert word in answer.out


def test_an_unknown_shell_is_one_sentence(call: Call) -> None:
    answer = call("completion", "fish")
    assert answer.code == 2 and "'bash', 'zsh', 'tcsh'" in answer.err
