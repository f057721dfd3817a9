"""Fleet reports made once for all the tests of this folder."""

from __future__ import annotations

import polars as pl
import pytest
from sample_fleet import facts, hostile_fleet, sample_fleet

from reports.fleet.write import fleet_pages


@pytest.fixture(scope="session")
def fleet() -> dict[str, pl.DataFrame]:
    return sample_fleet(60, 6)


@pytest.fixture(scope="session")
def fleet_html(fleet: dict[str, pl.DataFrame]) -> str:
    return fleet_pages(fleet, facts(), ["html"])["fleet.html"].decode()


@pytest.fixture(scope="session")
def hostile_fleet_html() -> str:
    return fleet_pages(hostile_fleet(), facts(folder="</script><b>"), ["html"])["fleet.html"].decode()
