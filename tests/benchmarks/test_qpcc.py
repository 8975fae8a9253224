"""The QPCC benchmark's parts on small problems."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from benchmarks.qpcc import command as qpcc
from benchmarks.qpcc import paper as qpcc_paper
from benchmarks.qpcc import sequences as qpcc_sequences
from warp_softbody.controllers import SolverOptions


def test_contacts_come_and_go_in_a_generated_sequence() -> None:
    sequence = qpcc_sequences.generated(4, 30)
    assert len({step.names for step in sequence}) > 2
    best = [np.inf] * 30
    row = qpcc_sequences.follow(sequence, best, SolverOptions(max_qps=40, kicks=0))
    assert row.residual < 1e-8 and row.gap == 0.0
    kicked = qpcc_sequences.follow(sequence, best, SolverOptions(max_qps=40, kicks=12))
    assert kicked.qps <= 40 and kicked.residual < 1e-8
    assert kicked.gap >= 0.0


def test_a_folder_of_instances_is_printed(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    # 0 <= x _|_ y >= 0, x + y = 1, nearest to (2, 0): the optimum is (1, 0), value 1/2.
    np.savez(
        tmp_path / "one.npz",
        Q=np.eye(2),
        c=np.array([-2.0, 0.0]),
        c0=2.0,
        A=np.ones((1, 2)),
        b=np.ones(1),
        L=np.eye(2)[:1],
        l0=np.zeros(1),
        R=np.eye(2)[1:],
        r0=np.zeros(1),
        f_best=0.5,
    )
    qpcc.main(["--instances", str(tmp_path), "--parts", "instances", "contacts"])
    assert "1 of 1 reached" in capsys.readouterr().out


def test_the_gap_ratio_compares_means() -> None:
    trials = [
        qpcc_paper.MethodComparison(static=3.0, ours=1.1, exhaustive=1.0, qps=3),
        qpcc_paper.MethodComparison(static=2.0, ours=1.0, exhaustive=1.0, qps=5),
    ]
    np.testing.assert_allclose(qpcc_paper.gap_ratio(trials), 3.0 / 0.1)
