"""The mapping file: read strictly; the starter file reads back."""

import pytest

from parsers.channels import ChannelInfo
from parsers.errors import MappingError
from parsers.mapping import propose, read_map, starter_map


def written(tmp_path, text):
    path = tmp_path / "map.toml"
    path.write_text(text, encoding="utf-8")
    return path


def test_all_keys_are_read(tmp_path):
    path = written(
        tmp_path,
        """
        [time]
        channel = "t"
        unit = "ms"
        [signals.accel_y]
        channel = "AY"
        unit = "g"
        scale = 2
        offset = -0.5
        invert = true
        sign_channel = "S"
        valid_range = [-5, 5]
        add = ["AY2"]
        where = ["W", 0, 1]
        [signals.wheel_speed_fl]
        channel = "W"
        [buses]
        "susp.dbc" = 2
        "body.dbc" = [1, 3]
        """,
    )
    made = read_map(path)
    assert made.buses == {"susp.dbc": (2,), "body.dbc": (1, 3)}
    assert (made.time_channel, made.time_unit) == ("t", "ms")
    entry = made.signals["accel_y"]
    assert entry.unit is not None
    assert entry.unit.scale == pytest.approx(9.80665)
    assert (entry.scale, entry.offset, entry.invert, entry.sign_channel) == (2.0, -0.5, True, "S")
    assert (entry.valid_range, entry.add, entry.where) == ((-5.0, 5.0), ("AY2",), ("W", 0.0, 1.0))
    assert entry.needed == ("AY", "AY2", "S", "W")
    assert made.signals["wheel_speed_fl"].unit is None


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("[signal.accel_y]\nchannel='a'", "unknown key 'signal'; did you mean 'signals'"),
        ("[buses]\n'a.dbc' = 'can0'", "'a.dbc' must be a bus's number or a list of them, found 'can0'"),
        ("[buses]\n'a.dbc' = []", "'a.dbc' must be a bus's number"),
        (
            "[signals.acel_y]\nchannel='a'",
            r"\[signals.acel_y\]: unknown signal 'acel_y'; did you mean 'accel_y'",
        ),
        ("[signals.accel_y_mps2]\nchannel='a'", "leave the unit away: 'accel_y'"),
        (
            "[signals.accel_y]\nchanel='a'",
            r"\[signals.accel_y\]: unknown key 'chanel'; did you mean 'channel'",
        ),
        ("[signals.accel_y]\nunit='g'", "'channel' is missing"),
        ("[signals.accel_y]\nchannel=1", "channel must be a text, found 1"),
        ("[signals.accel_y]\nchannel='a'\nunit='km/h'", "unit 'km/h' is no unit of acceleration; use one of"),
        ("[signals.accel_y]\nchannel='a'\nscale='2'", "scale must be a finite number, found '2'"),
        ("[signals.accel_y]\nchannel='a'\nscale=nan", "scale must be a finite number"),
        ("[signals.accel_y]\nchannel='a'\nscale=0", "other than 0"),
        ("[signals.accel_y]\nchannel='a'\ninvert=1", "invert must be true or false"),
        ("[signals.accel_y]\nchannel='a'\nvalid_range=[1]", "list of 2 numbers"),
        ("[signals.accel_y]\nchannel='a'\nvalid_range=[2, 1]", "low, high"),
        ("[signals.accel_y]\nchannel='a'\nwhere=['b', 1]", "where must be"),
        ("[signals]\naccel_y = 3", "must be a table, found 3"),
        ("signals = 3", "must be a table"),
        ("[time]\nunit='minutes'", "unknown time unit 'minutes'"),
        ("[signals.accel_y", "is not valid TOML"),
    ],
)
def test_mistakes_are_named(tmp_path, text, message):
    with pytest.raises(MappingError, match=message) as caught:
        read_map(written(tmp_path, text))
    assert "map.toml" in str(caught.value)
    assert "\n" not in str(caught.value)


def test_missing_and_binary_files_are_errors(tmp_path):
    with pytest.raises(MappingError, match="cannot be opened"):
        read_map(tmp_path / "no.toml")
    path = tmp_path / "binary.toml"
    path.write_bytes(b"\xff\xfe\x00")
    with pytest.raises(MappingError, match="not UTF-8"):
        read_map(path)


def test_starter_map_reads_back_and_maps_the_same(tmp_path):
    def can(message, signal, unit=None, **tags):
        return ChannelInfo(
            f"{message}.{signal}", message, unit, "can", tags={"message": message, "signal": signal, **tags}
        )

    channels = [
        can("ESP_02", "ESP_Gierrate", "Unit_DegreOfArcPerSecon"),
        can("ESP_02", "ESP_VZ_Gierrate"),
        can("ESP_02", "ESP_Querbeschleunigung"),
        can("STEER_ANGLE_SENSOR", "STEER_ANGLE", "deg"),
        can("STEER_ANGLE_SENSOR", "STEER_FRACTION", "deg"),
        can("CCVS1", "WheelBasedVehicleSpeed", "km/h"),
        can("VW", "AxleWeight", "kg"),
        can("VW", "AxleLocation"),
        can('odd"\n\x7f', "name \\", "bar"),
        ChannelInfo("text", "t", kind="text"),
    ]
    proposals = propose(channels, None)
    assert len(proposals) == 6
    text = starter_map(channels, proposals)
    assert "# by unit it could be" in text
    again = propose(channels, read_map(written(tmp_path, text)))
    assert list(again) == list(proposals)
    for signal, (first, *_) in proposals.items():
        (back,) = again[signal]
        for key in (
            "channels",
            "scale",
            "offset",
            "invert",
            "sign_channel",
            "valid_range",
            "where",
            "sum_axles",
            "kind",
        ):
            assert getattr(back, key) == getattr(first, key), (signal, key)
        assert back.unit.scale == first.unit.scale
        assert back.unit_from == "map file"


def test_a_channel_in_volts_needs_its_unit_in_the_map(tmp_path):
    path = tmp_path / "map.toml"
    entry = '[signals.suspension_deflection_fl]\nchannel = "Pot FL"\nscale = 20.0\n'
    channels = [ChannelInfo("Pot FL", "table", "V")]
    path.write_text(entry)
    with pytest.raises(
        MappingError, match=r"unit V is no unit of a length.*say the unit in the mapping file"
    ):
        propose(channels, read_map(path))
    path.write_text(f'{entry}unit = "mm"\n')
    (only,) = propose(channels, read_map(path))["suspension_deflection_fl"]
    assert (only.scale, only.unit.scale) == (20.0, 1e-3)


def test_a_signal_is_ignored_or_mapped_not_both(tmp_path):
    path = written(tmp_path, '[signals.pitch]\nchannel = "P"\nignore = true\n')
    with pytest.raises(MappingError, match=r"leaves the signal out, and 'channel' maps it to 'P'") as caught:
        read_map(path)
    assert caught.value.place == "[signals.pitch]"
    path = written(tmp_path, '[signals.pitch]\nchannel = "P"\nignore = false\n')
    assert read_map(path).signals["pitch"].channel == "P"
