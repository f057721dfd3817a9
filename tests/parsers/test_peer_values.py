"""Every value of a log of each format equals what the libraries of the field read (the logs of the import benchmark, short)."""

from __future__ import annotations

from pathlib import Path

import pytest

from benchmarks.import_logs.cases import CASES, Case, make_logs
from benchmarks.import_logs.sides import differences, ours, theirs


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("peers")
    make_logs(folder, 3, {case.name for case in CASES})
    return folder


@pytest.mark.filterwarnings("ignore::DeprecationWarning", "ignore::FutureWarning")
@pytest.mark.parametrize("case", CASES, ids=lambda case: case.name)
def test_every_value_equals_the_peers(case: Case, folder: Path) -> None:
    mine = ours(case, folder)
    assert sum(len(part) for parts in mine.values() for part in parts) > 5000
    for peer in case.peers:
        assert differences(mine, theirs(peer, case, folder)) == []


def test_a_wrong_value_is_found(folder: Path) -> None:
    mine = ours(CASES[0], folder)
    wrong = {name: [part.copy() for part in parts] for name, parts in mine.items()}
    next(iter(wrong.values()))[0][7] *= 1 + 1e-15 * 4
    assert len(differences(mine, wrong)) == 1
