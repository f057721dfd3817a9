"""Engines under test, and a Dask cluster in a process of its own."""

from __future__ import annotations

import subprocess
import sys
from collections.abc import Iterator

import pytest
from engine_help import environment

from pipelines.engines.base import Engine
from pipelines.engines.registry import engine_named

CLUSTER = """
import logging, sys
from distributed import LocalCluster

if __name__ == "__main__":
    with LocalCluster(n_workers=2, threads_per_worker=1, host="127.0.0.1", dashboard_address="127.0.0.1:0",
                      memory_limit=None, silence_logs=logging.CRITICAL) as cluster:
        print(cluster.scheduler_address, flush=True)
        sys.stdin.read()
"""


@pytest.fixture(scope="session")
def cluster(tmp_path_factory: pytest.TempPathFactory) -> Iterator[tuple[str, int]]:
    """Address and process of a running Dask cluster with two workers that know cogest."""
    pytest.importorskip("distributed")
    script = tmp_path_factory.mktemp("cluster") / "cluster.py"
    script.write_text(CLUSTER, encoding="utf-8")
    with subprocess.Popen(
        [sys.executable, str(script)],
        env=environment(),
        cwd=script.parent,
        stdin=subprocess.PIPE,
        stdout=subprocess.PIPE,
        text=True,
    ) as process:
        assert process.stdout is not None
        yield process.stdout.readline().strip(), process.pid
        process.communicate()


@pytest.fixture(params=["serial", "local", "dask"])
def engine(request: pytest.FixtureRequest) -> Engine:
    """Every engine that is registered, each with as many workers as two cores carry."""
    return _made(request, request.param)


@pytest.fixture(params=["local", "dask"])
def guarded(request: pytest.FixtureRequest) -> Engine:
    """Engines that keep limits."""
    return _made(request, request.param)


def _made(request: pytest.FixtureRequest, name: str) -> Engine:
    if name == "dask":
        address, _ = request.getfixturevalue("cluster")
        return engine_named("dask", None, address)
    return engine_named(name, None if name == "serial" else 2)
