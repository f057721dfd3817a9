"""The checks on recorded logs find what is known of each and nothing else."""

from pathlib import Path

import pytest

from parsers.load import load_drive

LOGS = Path(__file__).resolve().parents[3] / "shared" / "real_logs"


def real(name):
    path = LOGS / name
    if not path.exists():
        pytest.skip(f"{name} is not beside this repository")
    return load_drive([path])


def test_the_real_slalom():
    """Racelogic's box on a Volvo V40: what the log's README names, and nothing else."""
    record = real("volvo_v40_slalom_35kph.vbo").record
    made = {(each.signal, each.kind, each.applied) for each in record.decisions}
    assert made == {
        ("steering_wheel_angle", "spikes", True),
        ("yaw_rate", "sign", True),
        ("roll", "sign", True),
        ("pitch", "range", True),
        ("roll_rate", "offset", False),
        ("roll", "offset", False),
    }
    # a pitch angle that is left out for what it is has no sign to be told
    assert not any("sign of pitch:" in note for note in record.notes)
    (offset,) = (each for each in record.decisions if (each.signal, each.kind) == ("roll_rate", "offset"))
    assert float(offset.found.split()[-2]) == pytest.approx(0.36, abs=0.03)


def test_the_real_standstill():
    record = real("volvo_v40_standstill.vbo").record
    made = {(each.signal, each.kind) for each in record.decisions}
    assert made == {("steering_wheel_angle", "spikes"), ("roll_rate", "offset")}


@pytest.mark.parametrize("name", ["husky_imu_odometry.bag", "truck_j1939.mf4"])
def test_the_real_robot_and_truck_are_left_alone(name):
    assert real(name).record.decisions == ()
