"""What limited a result, where no method could run at all."""

from __future__ import annotations

from parsers.drive import ImportRecord, MappedChannel
from pipelines.limits import what_limits
from pipelines.results import Estimate
from pipelines.vehicles.vehicle import Vehicle


def test_where_nothing_ran_the_signals_and_one_example_are_named_not_a_wall_of_text() -> None:
    speed = MappedChannel("speed", "v", "m/s", "log", "column name 'v'", 10, 10.0)
    record = ImportRecord("CSV table", (), "", "complete", 10, {}, (), "time", None, 1.0, (speed,))
    skipped = [
        Estimate(estimator=name, status="skipped", reason=f"lacks accel_y and more for {name}")
        for name in ("first", "second", "third")
    ]
    limits = what_limits(record, skipped, {}, Vehicle())
    assert limits[0] == "No method could run. Signals that this log gives: speed."
    assert "first lacks accel_y" in limits[1]
    assert limits[2].endswith("first, second, third.")
    assert not any("more for second" in text for text in limits)
