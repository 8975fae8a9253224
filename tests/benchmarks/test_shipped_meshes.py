"""What coarser meshes gain, without its runs, and the meshes that are coarser still."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest

from benchmarks.charts.command import Stored
from benchmarks.fidelity.variants import COARSER
from benchmarks.robustness.other_meshes import make_meshes, meshes_of
from benchmarks.robustness.variations import EDGES
from benchmarks.shipped_meshes import costs, line, moved
from warp_softbody import scenes
from warp_softbody.accuracy.analysis.files import cells_of
from warp_softbody.accuracy.cases.case import shipped_coarse
from warp_softbody.accuracy.cases.table import CASES
from warp_softbody.body.mesh import TetMesh
from warp_softbody.characters.coarser_meshes import stored_name


def test_both_meshes_are_run_in_turn_and_medians_told(
    monkeypatch: pytest.MonkeyPatch, tmp_path: Path
) -> None:
    clock, asked = [0.0], list[tuple[str, ...]]()
    monkeypatch.setattr("benchmarks.shipped_meshes._cpu_seconds", lambda: clock[0])

    def run(scene: str, stage: Path, *more: str) -> dict[str, Any]:
        asked.append(more)
        coarse = int(more[1].removeprefix("coarse="))
        clock[0] += (0.4 if coarse else 1.0) * (3.0 if len(asked) < 5 else 1.0)
        return {
            "tets": 222 if coarse else 654,
            "simulated_seconds": 7.0,
            "real_time_factor": 40.0 if coarse else 14.0,
        }

    usual, shipped = costs("slide-f-left", 3, tmp_path, make=run)
    assert [more[1] for more in asked] == ["coarse=0", "coarse=2"] * 4
    # a short run of each first, which loads its kernels
    assert asked[0][2:] == ("--seconds", "0.1") and asked[2][2:] == ()
    assert (usual.cpu, shipped.cpu) == pytest.approx((1000.0 / 7.0, 400.0 / 7.0))
    case = CASES["slide-f-left"]
    points = [
        {**{knob: str(value) for knob, value in cells_of(one).items()}, "solver": "ours", **error}
        for one, error in ((case.usual, {"error": "0.05"}), (case.default, {"error": "0.02"}))
    ]
    told = line("slide-f-left", usual, shipped, Stored({}, points))
    assert told[1:3] == ["654, 222", "5 %, 2 %"] and told[-2:] == ["14, 40", "2.5"]
    assert line("slide-f-left", usual, shipped, None)[2] == "-, -"


def mean_edge(mesh: TetMesh) -> float:
    """Of all edges, m."""
    pairs = [mesh.tets[:, [a, b]] for a in range(4) for b in range(a)]
    edges = np.unique(np.sort(np.concatenate(pairs), axis=1), axis=0)
    ways = mesh.points[edges[:, 0]] - mesh.points[edges[:, 1]]
    return float(np.linalg.norm(ways, axis=1).mean())


@pytest.mark.parametrize("scene", moved())
def test_other_meshes_differ_from_what_ships(scene: str, tmp_path: Path) -> None:
    """Also where what ships is the coarsest that is stored."""
    pytest.importorskip("tetgen")
    shipped = scenes.make(scene).scene.character
    name = stored_name(shipped.name, shipped_coarse(scene))
    for edges in (COARSER, EDGES):
        # controllers look at the fibres of the usual one
        make_meshes(tmp_path, edges, dict.fromkeys([name, shipped.name]))
        with meshes_of(tmp_path, edges):
            other = scenes.make(scene).scene.character
        assert other.mesh.smallest_dihedral_angle > 9.0
        assert not np.array_equal(other.mesh.tets, shipped.mesh.tets)
        assert set(other.regions) == set(shipped.regions)
        assert all(len(nodes) for nodes in other.regions.values())
        if edges == COARSER:
            assert len(other.mesh.tets) < 0.8 * len(shipped.mesh.tets)
            assert mean_edge(other.mesh) > 1.1 * mean_edge(shipped.mesh)
