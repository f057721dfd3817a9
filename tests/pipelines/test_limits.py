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
    assert limits[2] == "What each of the others lacks stands under Estimators."
    assert not any("more for second" in text for text in limits)


def test_methods_that_did_not_run_beside_others_are_counted_not_listed_by_names_of_the_code() -> None:
    record = ImportRecord("CSV table", (), "", "complete", 10, {}, (), "time", None, 1.0, ())
    ran = Estimate(estimator="first", status="ran", reason="")
    skipped = Estimate(estimator="base_excitation_batch", status="skipped", reason="lacks accel_z")
    limits = what_limits(record, [ran, skipped, skipped], {}, Vehicle())
    assert limits[-1].startswith("2 of 3 methods did not run")
    assert not any("base_excitation_batch" in text for text in limits)
