"""Where the sample logs and, on machines that have them, the recorded logs are."""

from __future__ import annotations

from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parent.parent


@pytest.fixture(scope="session")
def samples() -> Path:
    """The folder of sample logs."""
    return ROOT / "sample_logs"


@pytest.fixture(scope="session")
def real_logs() -> Path:
    """The folder of recorded logs; the test skips where it is absent."""
    folder = ROOT.parent / "shared" / "real_logs"
    if not folder.is_dir():
        pytest.skip("the recorded logs (shared/real_logs) are not on this machine")
    return folder
