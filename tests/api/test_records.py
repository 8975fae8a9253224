"""Records behave as Python objects should: equality, hash, copies, pickles, a short text."""

from __future__ import annotations

import copy
import pickle
from dataclasses import replace
from typing import Any

import numpy as np
import pytest

import warp_softbody as wsb
from tests.api import samples
from warp_softbody import controllers

RECORDS = [
    samples.muscled(),
    samples.scene(),
    samples.muscled().mesh,
    samples.muscled().material,
    samples.muscled().muscles[0],
    samples.muscled().fibers[0],
    wsb.Body(character=samples.muscled()),
    wsb.Plane(),
    wsb.HeightField(heights=np.eye(3)),
    wsb.FrictionMap(factors=np.eye(3)),
    wsb.TriangleGround(vertices=np.eye(3), faces=np.array([[0, 1, 2]])),
    wsb.SimulationOptions(),
    wsb.ControlOptions(),
    controllers.BalanceGains(),
    samples.problem(),
    controllers.QPCC(Q=np.eye(2), c=np.ones(2)),
]
WITH_WRITABLE_ARRAYS = [
    samples.frame(),
    samples.view(),
    controllers.solve_qpcc(samples.problem()),
    controllers.ground_patches(samples.view(), ("base",))[0],
]


def name_of(record: object) -> str:
    return type(record).__name__


@pytest.mark.parametrize("record", RECORDS + WITH_WRITABLE_ARRAYS, ids=name_of)
def test_copies_are_equal(record: Any) -> None:
    for again in (pickle.loads(pickle.dumps(record)), copy.deepcopy(record), copy.copy(record)):
        assert again == record
        assert not again != record
    assert record != 3
    assert len(repr(record)) < 1500
    assert "\n" not in repr(record)


@pytest.mark.parametrize("record", RECORDS, ids=name_of)
def test_equal_records_have_one_hash(record: Any) -> None:
    assert len({record, copy.deepcopy(record)}) == 1


def test_copies_are_read_only_and_work() -> None:
    again = copy.deepcopy(samples.scene())
    mesh = again.character.mesh
    for array in (mesh.points, mesh.tets, again.character.region("base"), again.character.fixed):
        assert not array.flags.writeable
    ends = [list(wsb.Simulation(s).run(0.05))[-1] for s in (again, samples.scene())]
    assert ends[0] == ends[1]


def test_different_records_differ() -> None:
    character = samples.muscled()
    moved = wsb.placed(character, translation=(0.0, 0.0, 1.0))
    assert moved != character
    assert replace(character, color=(0.0, 0.0, 0.0)) != character
    assert replace(character, regions={}) != character
    assert samples.scene() != replace(samples.scene(), gravity=(0.0, 0.0, 0.0))
    assert samples.frame() != replace(samples.frame(), time=1.0)
