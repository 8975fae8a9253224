"""What a run would refuse is refused where the scene file is read, with its line."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from tests.support.bodies import muscular_bar
from warp_softbody import scene_files
from warp_softbody.errors import InputError
from warp_softbody.scene_files.scene_file import ENDINGS, SIDES, RunOutput
from warp_softbody.stage_exports.conventions import EXTENSIONS
from warp_softbody.stage_exports.pictures.picture import checked_size

CUBE = '[character]\nname = "cube"\nshape = "box"\nsize = [0.2, 0.2, 0.2]\ncells = [2, 2, 2]\n'
OUTPUT = CUBE + "[output]\n"
LETTER = '[character]\nshape = "letter_i"\ncoarse = 1\n'
TWIN = CUBE.replace("[character]", "[[bodies]]").replace('"cube"', '"twin"')
FIBRE = (
    '[[character.muscles]]\nname = "m"\nstrength = 1e5\nkernel_width = 0.1\n'
    'fibers = [{ name = "f", vertices = [[0.0, 0.0, 0.05], [0.0, 0.0, 4.9]] }]\n'
)


@pytest.mark.parametrize(
    ("text", "sentence"),
    [
        (OUTPUT + "movie = 'a.avi'\n", "7: output.movie: RunOutput.movie must be a name in .gif"),
        (OUTPUT + "stage = 'a.obj'\n", "7: output.stage: RunOutput.stage must be a name in .usdc"),
        (OUTPUT + "stage = 'no/a.usdc'\n", "7: output.stage: there is no folder 'no' beside"),
        (OUTPUT + "size = [3, 3]\n", "7: output.size: RunOutput.size must be a whole number"),
        (OUTPUT + "movie = 'a.mp4'\nsize = [33, 32]\n", "8: output.size: .* even numbers"),
        (OUTPUT + "movie = 'z.gif'\nplots = './z.gif'\n", "8: output.plots: .* the same name"),
        (LETTER + "[controller]\nkind = 'crawl'\n", "5: controller.kind: .* no region 'corner_0'"),
        (
            LETTER + "[controller]\nkind = 'balance'\n[[bodies]]\nname = 'twin'\n"
            "shape = 'letter_i'\ncoarse = 1\ntranslation = [3, 0, 0]\n"
            "[bodies.controller]\nkind = 'crawl'\n",
            r"12: bodies\[0\].controller.kind: .* no region 'corner_0'",
        ),
        (CUBE + FIBRE, "6: character.muscles: fibre 'f': vertex .* lies outside the mesh"),
        (CUBE + TWIN, r"6: bodies\[0\]: bodies 'cube' and 'twin' fill the same place"),
    ],
)
def test_what_cannot_run_is_told_with_its_line(text: str, sentence: str, tmp_path: Path) -> None:
    file = tmp_path / "own.toml"
    file.write_text(text)
    with pytest.raises(InputError, match=sentence) as raised:
        scene_files.read(file)
    assert str(raised.value).startswith(f"{file}:")


def test_fibres_of_a_character_file(tmp_path: Path) -> None:
    bar = muscular_bar()
    moved = bar.mesh.points + 5.0
    type(bar)(name="far", mesh=type(bar.mesh)(moved, bar.mesh.tets), muscles=bar.muscles).save(
        tmp_path / "far.char"
    )
    (tmp_path / "own.toml").write_text('[character]\nfile = "far.char"\n')
    with pytest.raises(InputError, match=r"2: character.file: fibre .* lies outside the mesh"):
        scene_files.read(tmp_path / "own.toml")


def test_endings_and_sides_are_those_of_what_is_written() -> None:
    assert ENDINGS["stage"] == EXTENSIONS
    for side in SIDES.values():
        assert checked_size((side, side)) == RunOutput(size=(side, side)).size
    for side in (SIDES["low"] - 1, SIDES["high"] + 1):
        with pytest.raises(InputError):
            checked_size((side, side))


def test_a_mark_of_the_byte_order_is_taken(tmp_path: Path) -> None:
    np.savetxt(tmp_path / "h.csv", np.eye(2), delimiter=",", encoding="utf-8-sig")
    text = '[ground]\nkind = "heights"\nfile = "h.csv"\n' + CUBE
    (tmp_path / "own.toml").write_text(text, encoding="utf-8-sig")
    assert (tmp_path / "own.toml").read_bytes().startswith(b"\xef\xbb\xbf")
    ground = scene_files.read(tmp_path / "own.toml").plan.scene.ground
    np.testing.assert_array_equal(getattr(ground, "heights", None), np.eye(2))


def test_links_do_not_lead_out_of_the_folder(tmp_path: Path) -> None:
    own, other = tmp_path / "own", tmp_path / "other"
    own.mkdir()
    other.mkdir()
    try:
        (own / "in").symlink_to(other)
        (own / "b.gif").symlink_to(other / "b.gif")
        (tmp_path / "linked").symlink_to(own)
    except OSError:
        pytest.skip("no links here")
    file = own / "own.toml"
    for line in ("stage = 'in/a.usdc'", "plots = 'in/plots'", "movie = 'b.gif'"):
        file.write_text(OUTPUT + line + "\n")
        with pytest.raises(InputError, match=r"7: output.*leads out of the folder of the file by"):
            scene_files.read(file)
    # the folder itself may be reached by one
    file.write_text(OUTPUT + "stage = 'a.usdc'\n")
    assert scene_files.read(tmp_path / "linked" / "own.toml").output.stage == "a.usdc"
