"""Where the sample logs and, on machines that have them, the recorded logs are."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path

import pytest

from parsers.algebra_threads import one_algebra_thread

# before anything loads numpy: tests within this process give what the program gives
one_algebra_thread()

# fixtures that several folders of tests use
from remote_store import counted, s3_server, s3_store  # noqa: E402, F401

from parsers.can.database_cache import FOLDER_VARIABLE  # noqa: E402

ROOT = Path(__file__).resolve().parent.parent


@pytest.fixture(scope="session", autouse=True)
def cache_of_its_own(tmp_path_factory: pytest.TempPathFactory) -> Iterator[None]:
    """Databases that the tests read are not kept in the user's cache, nor taken from there."""
    with pytest.MonkeyPatch.context() as patch:
        patch.setenv(FOLDER_VARIABLE, str(tmp_path_factory.mktemp("databases")))
        yield


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
