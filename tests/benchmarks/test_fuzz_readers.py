"""A small run of mutated files: every one is refused in a sentence, whole, or told."""

from __future__ import annotations

from pathlib import Path

import pytest

from benchmarks.fuzz.formats import KINDS
from benchmarks.fuzz.readers import GOOD, fuzz, main
from warp_softbody.errors import MeshError


def test_no_mutated_file_is_taken_for_another_body(tmp_path: Path) -> None:
    outcomes = list(fuzz(2 * len(KINDS), 4, tmp_path / "files", tmp_path / "kept"))
    assert [outcome for outcome in outcomes if outcome.verdict not in GOOD] == []
    assert {outcome.kind for outcome in outcomes} == {kind.name for kind in KINDS}
    assert not (tmp_path / "kept").exists()


def test_it_tells_and_keeps_what_is_wrong(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    def broken(kind: object, path: Path) -> tuple[int, int]:
        if path.suffix == ".inp":
            raise KeyError("what")
        if path.suffix == ".vtu":
            return 1, 1
        raise MeshError(f"{path}: no")

    arguments = ["--files", str(len(KINDS)), "--seed", "1", "--keep", str(tmp_path)]
    assert main(arguments, broken) == 1
    lines = capsys.readouterr().out.splitlines()
    assert lines[0] == "abaqus 0: traceback: KeyError: 'what'"
    assert lines[-1].split() == ["all", str(len(KINDS) - 3), "0", "0", "1", "0", "2"]
    assert (tmp_path / "abaqus-1-0-traceback" / "s.inp").is_file()
