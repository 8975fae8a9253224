"""Files that are no stages of ours, or no longer: read, or refused in one sentence, in time."""

from __future__ import annotations

import os
import sys
import time
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from pxr import Gf, Sdf, Vt

from benchmarks.fuzz.stages import mutated, tried
from warp_softbody.errors import InputError
from warp_softbody.stage_exports import StageWriter, body_names, read_take, validate
from warp_softbody.stage_exports.usd.isolation import apart

SKIN, TETS, FIBERS = (f"/World/block/{name}" for name in ("Skin", "Tets", "Fibers"))


def test_mutated_files_are_dealt_with(tmp_path: Path) -> None:
    """A few of `python -m benchmarks.fuzz.stages`, which makes thousands."""
    outcomes = [tried(path) for path, _ in mutated(tmp_path, 41, 3)]
    assert set(outcomes) == {"read", "refused"}, outcomes


def _tet_far_away(layer: Any) -> None:
    tets = layer.GetAttributeAtPath(f"{TETS}.tetVertexIndices")
    indices = np.array(tets.default)
    indices[3, 1] = 268_435_874
    tets.default = Vt.Vec4iArray.FromNumpy(indices)


def _face_below_zero(layer: Any) -> None:
    faces = layer.GetAttributeAtPath(f"{SKIN}.faceVertexIndices")
    indices = np.array(faces.default)
    indices[0] = -16_777_005
    faces.default = Vt.IntArray.FromNumpy(indices)


def _points_not_finite(layer: Any) -> None:
    points = np.array(layer.QueryTimeSample(f"{SKIN}.points", 2.0))
    points[1, 1] = np.nan
    layer.SetTimeSample(f"{SKIN}.points", 2.0, Vt.Vec3fArray.FromNumpy(points))


def _fewer_points(layer: Any) -> None:
    layer.SetTimeSample(f"{TETS}.points", 2.0, Vt.Vec3fArray([Gf.Vec3f(0.0)]))


def _no_activations(layer: Any) -> None:
    for code in layer.ListTimeSamplesForPath(f"{FIBERS}.primvars:activation"):
        layer.SetTimeSample(f"{FIBERS}.primvars:activation", code, Vt.FloatArray([1.0]))


def _no_color(layer: Any) -> None:
    prim = layer.GetPrimAtPath(SKIN)
    prim.RemoveProperty(prim.properties["primvars:displayColor"])


def _no_friction(layer: Any) -> None:
    prim = layer.GetPrimAtPath("/World/Ground")
    prim.RemoveProperty(prim.properties["softbody:friction"])


def _stopped_clock(layer: Any) -> None:
    layer.timeCodesPerSecond = 0.0


@pytest.mark.parametrize(
    ("damage", "sentence"),
    [
        (_tet_far_away, "tets name the point 268435874 of 30"),
        (_face_below_zero, "faces of the skin name the point -16777005"),
        (_points_not_finite, "points of the skin hold a number that is not finite"),
        (_fewer_points, "has 1 of 'points' at the time code 2, and 30 before"),
        (_no_activations, "points of fibers have the shape"),
        (_no_color, "has no value of 'primvars:displayColor'"),
        (_no_friction, "its ground has no value of 'softbody:friction'"),
        (_stopped_clock, "time codes per second must be a positive number"),
    ],
)
def test_damaged_values_are_named(
    write_take: Any, damage: Callable[[Any], None], sentence: str
) -> None:
    path: Path = write_take("damaged.usdc")
    layer = Sdf.Layer.OpenAsAnonymous(str(path))
    damage(layer)
    layer.Export(str(path))
    with pytest.raises(InputError, match=sentence):
        read_take(path)


def test_a_take_from_elsewhere_is_read_as_one_of_ours(write_take: Any, tmp_path: Path) -> None:
    """By a child process, to the same numbers."""
    own: Path = write_take("own.usdc")
    copy = tmp_path / "copy.usdc"
    copy.write_bytes(own.read_bytes())
    one, other = read_take(own), read_take(copy)
    for name in ("times", "tet_points", "velocities", "fiber_points", "activations", "skin_faces"):
        np.testing.assert_array_equal(getattr(one, name), getattr(other, name))
    assert (one.ground, one.metadata, one.color) == (other.ground, other.metadata, other.color)
    assert body_names(copy) == ("block",) and validate(copy) == []
    with pytest.raises(InputError, match="holds no body 'blok'; it holds: block"):
        read_take(copy, "blok")


@pytest.mark.parametrize(
    ("ending", "sentence"),
    [
        ("kill -ALRM $$", "takes longer than a file of its size may"),
        ("kill -PROF $$", "takes longer than a file of its size may"),
        ("kill -SEGV $$", "damaged so that USD ends with SIGSEGV"),
        ("exit 1", "needs too much memory"),
        ("exit 0", "damaged so that USD ends"),
    ],
)
def test_a_child_that_ends_is_one_sentence(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, ending: str, sentence: str
) -> None:
    """A shell script that ends in every way stands for the interpreter that would read."""
    path = tmp_path / "any.usdc"
    path.write_bytes(b"PXR-USDC")
    child = tmp_path / "child"
    child.write_text(f"#!/bin/sh\n{ending}\n")
    child.chmod(0o755)
    monkeypatch.setattr(sys, "executable", str(child))
    with pytest.raises(InputError, match=sentence):
        apart("extract", path, None, False)
    assert sentence in validate(path)[0]


def test_a_long_rest_is_no_damage(scene: Any, make_frames: Any, tmp_path: Path) -> None:
    """Frames that are all the same take few bytes, and the child may take its time for them."""
    own, copy = tmp_path / "own.usdc", tmp_path / "copy.usdc"
    first = next(make_frames(scene, 1))
    with StageWriter(own, scene, chunk_frames=400) as stage:
        for index in range(400):
            stage.write(replace(first, index=index, time=index / 30))
    copy.write_bytes(own.read_bytes())
    assert len(copy.read_bytes()) < 150_000
    assert len(read_take(copy)) == 400


def test_a_file_that_never_ends_is_left(tmp_path: Path) -> None:
    """A child that waits for a writer which does not come is ended."""
    pipe = tmp_path / "pipe.usda"
    os.mkfifo(pipe)
    layer = Sdf.Layer.CreateAnonymous(".usda")
    layer.subLayerPaths.append(str(pipe))
    layer.Export(str(tmp_path / "waits.usda"))
    begun = time.monotonic()
    with pytest.raises(InputError, match="takes longer than a file of its size may"):
        apart("extract", tmp_path / "waits.usda", None, False, seconds=0.5)
    assert time.monotonic() - begun < 60.0
