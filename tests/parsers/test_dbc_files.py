"""DBC files as they are met: encodings, multiplexing, float types, wrong grammar, and what is no DBC."""

from __future__ import annotations

from pathlib import Path

import pytest

from parsers.can.database import builtin_j1939, load_database, load_databases
from parsers.can.definitions import BitField, MessageDef, is_proprietary, pgn_of
from parsers.can.labels import invalid_codes
from parsers.errors import DatabaseError
from parsers.importer import ImportLog

REAL = Path(__file__).resolve().parents[3] / "shared" / "real_logs"

HEAD = 'VERSION ""\n\nBU_: A\n\n'
ONE = HEAD + 'BO_ 291 Motion: 8 A\n SG_ Angle : 7|16@0- (0.1,-5) [0|0] "{unit}" A\n'


def load(tmp_path: Path, text: str | bytes, log: ImportLog | None = None) -> tuple[MessageDef, ...]:
    path = tmp_path / "x.dbc"
    path.write_bytes(text if isinstance(text, bytes) else text.encode())
    return load_database(path, log or ImportLog())


@pytest.mark.parametrize("encoding", ["utf-8", "utf-8-sig", "cp1252", "latin-1"])
def test_encodings(tmp_path: Path, encoding: str) -> None:
    ((signal,),) = (m.signals for m in load(tmp_path, ONE.format(unit="°/s").encode(encoding)))
    assert (signal.name, signal.unit, signal.scale, signal.offset) == ("Angle", "°/s", 0.1, -5.0)
    assert signal.field == BitField(7, 16, False)
    assert signal.signed


def test_bytes_that_cp1252_does_not_know(tmp_path: Path) -> None:
    (message,) = load(tmp_path, ONE.format(unit="@").encode().replace(b'"@"', b'"\x81\xb0"'))
    assert message.signals[0].unit == "\x81°"


def test_facts_of_a_signal(tmp_path: Path) -> None:
    text = (
        HEAD
        + 'BO_ 2566844926 CCVS1: 8 A\n SG_ F : 0|32@1- (1,0) [0|0] "" A\n SG_ D : 32|8@1+ (2,0) [0|0] "" A\n\n'
        + 'CM_ SG_ 2566844926 D "a comment";\n'
        + 'BA_DEF_ SG_ "SPN" INT 0 524287;\nBA_DEF_DEF_ "SPN" 0;\nBA_ "SPN" SG_ 2566844926 D 84;\n'
        + 'VAL_ 2566844926 D 255 "SNA" 254 "Error" 1 "one" ;\nSIG_VALTYPE_ 2566844926 F : 1;\n'
    )
    (message,) = load(tmp_path, text)
    assert (message.can_id, message.j1939, message.extended) == (2566844926, True, True)
    floating, coded = message.signals
    assert floating.is_float
    assert (coded.spn, coded.invalid, coded.comment) == (84, (254, 255), "a comment")


def test_real_truck_database() -> None:
    path = REAL / "truck_j1939.dbc"
    if not path.exists():
        pytest.skip("shared/real_logs is not beside the repository")
    log = ImportLog()
    messages = load_database(path, log)
    assert [(m.name, m.can_id, pgn_of(m.can_id), m.j1939) for m in messages] == [
        ("EEC1", 2364540158, 61444, True),
        ("CCVS1", 2566844926, 65265, True),
    ]
    assert [s.spn for m in messages for s in m.signals] == [190, 84]
    assert log.notes == []


def test_builtin_j1939_loads_clean() -> None:
    log = ImportLog()
    messages = {m.name: m for m in builtin_j1939(log)}
    assert log.notes == []
    assert {name: pgn_of(m.can_id) for name, m in messages.items()} == {
        "EBC1": 61441, "EEC2": 61443, "EEC1": 61444, "VDC2": 61449, "ARI": 61482, "ACS": 61485, "HRW": 65134,
        "CVW": 65136, "EBC2": 65215, "VDS": 65256, "VW": 65258, "CCVS1": 65265, "VP": 65267,
    }  # fmt: skip
    assert all(m.j1939 for m in messages.values())
    numbered = {s.name: s.spn for s in messages["VDC2"].signals}
    assert (numbered["SteeringWheelAngle"], numbered["YawRate"], numbered["LateralAcceleration"]) == (
        1807,
        1808,
        1809,
    )


def test_group_numbers() -> None:
    assert pgn_of(0x98FEF1FE) == 65265
    assert pgn_of(0x8C0003FE) == pgn_of(0x8C00FFFE) == 0
    assert pgn_of(0x99F10101) == 0x1F101
    assert pgn_of(0x123) is None
    assert pgn_of(0x9BF00400) is None
    assert [is_proprietary(pgn) for pgn in (0xEF00, 0xFF12, 0x1FF00, 0xFEF1, 0xF009)] == [
        True,
        True,
        True,
        False,
        False,
    ]


@pytest.mark.parametrize(
    ("choices", "length", "codes"),
    [
        ({255: "SNA", 254: "Sensor error", 0: "zero"}, 8, (254, 255)),
        ({-128: "Signal not available"}, 8, (128,)),
        ({1022: "Init_(ungueltig)", 1023: "Fehler"}, 10, (1022, 1023)),
        ({0: "no error", 1: "error"}, 1, ()),
        ({3: "SNA"}, 2, (3,)),
        ({0: "off", 1: "on", 2: "fault", 3: "SNA"}, 2, ()),
        ({7: "no fault"}, 8, ()),
        ({0: "Error free", 32767: "Fault_none", 32766: "Fehlerfrei", 1: "Signal_NoFault"}, 16, ()),
        ({0: "Error_Offset", 1: "Fault"}, 16, (0, 1)),
        ({0: "Initial position"}, 8, ()),
        ({0: "zero", 25500: "N/A", 5000: "Failure"}, 16, (5000, 25500)),
        (
            dict(enumerate(["unknown", "No value", "No data", "n.a.", "NA", "undef"])),
            8,
            (*range(6),),
        ),
        (
            dict(enumerate(["Sensor defect", "Defekt", "Out of range", "out_of_range"])),
            8,
            (*range(4),),
        ),
        (
            dict(enumerate(["Overflow", "Underflow", "Fail", "Failed", "Not used"])),
            8,
            (*range(5),),
        ),
        (
            dict(enumerate(["Sensor_Init", "Initialising", "Implausible", "Nicht_verbaut"])),
            8,
            (*range(4),),
        ),
        (
            dict(enumerate(["SensorFailure", "SignalError", "Erreur", "non disponible"])),
            8,
            (*range(4),),
        ),
        (
            dict(enumerate(["No failure", "NoFail", "Fail-safe", "not failed", "no overflow"])),
            8,
            (),
        ),
        (
            dict(enumerate(["NoFault", "ErrorFree", "Sedna", "initial", "known", "national"])),
            8,
            (),
        ),
    ],
)
def test_codes_that_value_tables_call_invalid(
    choices: dict[int, str], length: int, codes: tuple[int, ...]
) -> None:
    assert invalid_codes(choices, length) == codes


def test_bit_timing_does_not_cost_a_database_its_grammar(tmp_path: Path) -> None:
    log = ImportLog()
    load(
        tmp_path, 'VERSION ""\n\nBS_: 500000:0,0\n\nBU_: A\n\n' + ONE.removeprefix(HEAD).format(unit="m"), log
    )
    assert log.notes == []


def test_value_tables_count_where_the_grammar_is_broken(tmp_path: Path) -> None:
    text = ONE.format(unit="m") + 'VAL_ 291 Angle 32767 "SNA" 32766 "error" 0 "zero" ;\nthis is no DBC {{{\n'
    log = ImportLog()
    (message,) = load(tmp_path, text, log)
    assert message.signals[0].invalid == (32766, 32767)
    assert "not a correct DBC" in log.notes[0]


def test_what_does_not_parse_is_read_line_by_line(tmp_path: Path) -> None:
    text = (
        HEAD
        + 'BO_ 291 Good: 8 A\n SG_ X : 0|16@1- (0.5,1) [0|0] "m" A\n SG_ broken line\n'
        + ' SG_ Mux M : 16|8@1+ (1,0) [0|0] "" A\n SG_ Y m2 : 24|32@1- (1,0) [0|0] "" A\n'
        + "BO_ 9000 TooBig: 8 A\nSIG_VALTYPE_ 291 Y : 1;\nthis is no DBC {{{\n"
    )
    log = ImportLog()
    (message,) = load(tmp_path, text, log)
    assert [s.name for s in message.signals] == ["X", "Mux", "Y"]
    x, _, y = message.signals
    assert (x.scale, x.offset, x.signed, x.unit) == (0.5, 1.0, True, "m")
    assert y.is_float
    assert (y.gates[0].multiplexer, y.gates[0].values) == ("Mux", (2,))
    assert any(
        "not a correct DBC" in note and "2 lines were left out (the first: line 7)" in note
        for note in log.notes
    )


@pytest.mark.parametrize(
    ("line", "floats"), [("Y 1;", True), ("Y: 1 ;", True), ("Y", False), ("Y : 9;", False)]
)
def test_the_type_of_a_float_is_read_without_its_colon_or_is_counted(
    tmp_path: Path, line: str, floats: bool
) -> None:
    text = (
        HEAD + 'BO_ 291 Good: 8 A\n SG_ Y : 0|32@1- (1,0) [0|0] "m" A\n' + f"SIG_VALTYPE_ 291 {line}\n{{{{\n"
    )
    log = ImportLog()
    ((signal,),) = (message.signals for message in load(tmp_path, text, log))
    assert signal.is_float is floats
    assert any("1 lines were left out" in note for note in log.notes) is not floats


@pytest.mark.parametrize("factor", ["(0,05,0)", "(1/20,0)", "(0.5)", ""])
def test_a_signal_whose_scale_cannot_be_read_is_left_out(tmp_path: Path, factor: str) -> None:
    """It is not raw counts: what a bit is worth is not known."""
    text = (
        HEAD
        + f'BO_ 291 Good: 8 A\n SG_ X : 0|16@1- {factor} [0|0] "m" A\n SG_ Y : 16|16@1- (2,1) [0|0] "m" A\n'
        + "this is no DBC {{{\n"
    )
    log = ImportLog()
    (message,) = load(tmp_path, text, log)
    assert [(s.name, s.scale, s.offset) for s in message.signals] == [("Y", 2.0, 1.0)]
    assert any("1 lines were left out (the first: line 6)" in note for note in log.notes)


NESTED = (
    HEAD
    + 'BO_ 256 M: 8 A\n SG_ Mux M : 0|8@1+ (1,0) [0|0] "" A\n SG_ Sub m1M : 8|8@1+ (1,0) [0|0] "" A\n'
    + ' SG_ P m0 : 16|16@1+ (1,0) [0|0] "" A\n SG_ Q m0 : 16|16@1+ (1,0) [0|0] "" A\n'
    + ' SG_ R m5 : 32|16@1+ (1,0) [0|0] "" A\n\n'
    + "SG_MUL_VAL_ 256 Sub Mux 1-1;\nSG_MUL_VAL_ 256 P Mux 0-0;\nSG_MUL_VAL_ 256 Q Sub 0-0;\n"
    + "SG_MUL_VAL_ 256 R Sub 5-7,\n 9-9;\n"
)


def gates(message: MessageDef) -> dict[str, list[tuple[str, tuple[int, ...]]]]:
    return {s.name: [(gate.multiplexer, gate.values) for gate in s.gates] for s in message.signals}


@pytest.mark.parametrize("broken", ["", "this is no DBC {{{\n"])
def test_nested_multiplexers_are_read_line_by_line_too(tmp_path: Path, broken: str) -> None:
    (message,) = load(tmp_path, NESTED + broken)
    top = ("Mux", (1,))
    assert gates(message) == {
        "Mux": [],
        "Sub": [top],
        "P": [("Mux", (0,))],
        "Q": [("Sub", (0,)), top],
        "R": [("Sub", (5, 6, 7, 9)), top],
    }


@pytest.mark.parametrize("ranges", ["0-4294967295", "0", "7-3", "0-99999999999999"])
def test_signals_in_untold_frames_are_left_out_and_named(tmp_path: Path, ranges: str) -> None:
    log = ImportLog()
    text = NESTED.replace("SG_MUL_VAL_ 256 Q Sub 0-0;\n", "").replace("R Sub 5-7,\n 9-9", f"R Sub {ranges}")
    (message,) = load(tmp_path, text + "this is no DBC {{{\n", log)
    assert sorted(gates(message)) == ["Mux", "P", "Sub"]
    assert any("M.Q, M.R" in note and "in which frames" in note for note in log.notes)


def test_multiplexers_in_a_circle_are_left_out(tmp_path: Path) -> None:
    text = NESTED.replace("Sub Mux 1-1", "Sub Sub 1-1") + "this is no DBC {{{\n"
    (message,) = load(tmp_path, text)
    assert sorted(gates(message)) == ["Mux", "P"]


def test_a_number_without_its_zero_does_not_cost_a_database_its_grammar(tmp_path: Path) -> None:
    log = ImportLog()
    text = ONE.format(unit=".5(+.5)").replace("(0.1,-5) [0|0]", "(.5,-.25) [-.5|+.5]")
    (message,) = load(tmp_path, text, log)
    (signal,) = message.signals
    assert log.notes == []
    assert (signal.scale, signal.offset, signal.unit) == (0.5, -0.25, ".5(+.5)")


@pytest.mark.parametrize(
    ("content", "words"),
    [
        (b"", "no messages|not a CAN database"),
        (b"hello, this is a letter\n", "not a CAN database"),
        (b"\x00\x01\x02", "binary"),
        (b'VERSION ""\n\nBU_: A\n', "no messages"),
    ],
)
def test_what_is_no_database_is_refused_in_one_line(tmp_path: Path, content: bytes, words: str) -> None:
    with pytest.raises(DatabaseError, match=words) as caught:
        load(tmp_path, content)
    assert "x.dbc" in str(caught.value)
    assert "\n" not in str(caught.value)


@pytest.mark.parametrize(
    ("name", "content", "words"),
    [
        ("x.arxml", '<?xml version="1.0"?>\n<AUTOSAR></AUTOSAR>', "AUTOSAR.*cantools convert x.arxml x.dbc"),
        ("x.kcd", '<NetworkDefinition xmlns="x"></NetworkDefinition>', "KCD.*cantools convert x.kcd x.dbc"),
        ("x.sym", 'FormatVersion=6.0 // Do not edit\nTitle="x"\n', "SYM.*cantools convert x.sym x.dbc"),
        ("x.xml", '<fx:FIBEX xmlns:fx="x"></fx:FIBEX>', "FIBEX description, where a DBC.*export a DBC"),
    ],
)
def test_other_descriptions_of_a_bus_are_named(tmp_path: Path, name: str, content: str, words: str) -> None:
    (tmp_path / name).write_text(content)
    with pytest.raises(DatabaseError, match=words):
        load_database(tmp_path / name, ImportLog())


def test_missing_file_is_a_database_error(tmp_path: Path) -> None:
    with pytest.raises(DatabaseError, match="No such file"):
        load_databases((tmp_path / "no.dbc",), ImportLog())


def test_billions_of_multiplexer_values_are_cut(tmp_path: Path) -> None:
    text = (
        HEAD
        + 'BO_ 100 N: 8 A\n SG_ M0 M : 0|32@1+ (1,0) [0|0] "" A\n SG_ S m0 : 32|8@1+ (1,0) [0|0] "" A\n\n'
        + "SG_MUL_VAL_ 100 S M0 0-4294967295;\n"
    )
    log = ImportLog()
    (message,) = load(tmp_path, text, log)
    assert len(message.signals[1].gates[0].values) == 4096
    assert any("4294967295" in note for note in log.notes)


def test_second_message_with_one_id_is_dropped_with_a_note(tmp_path: Path) -> None:
    log = ImportLog()
    twice = ONE.format(unit="m") + '\nBO_ 291 Again: 8 A\n SG_ B : 0|8@1+ (1,0) [0|0] "" A\n'
    (message,) = load(tmp_path, twice, log)
    assert message.name == "Motion"
    assert any("twice" in note for note in log.notes)


@pytest.mark.parametrize(
    ("old", "new"),
    [
        (": 8 A", ": 999999999 A"),
        ("7|16", "77777777|16"),
        ("7|16", "7|16161616"),
        ("BO_ 291 Motion: 8", "BO_ 291 Motion:\n 99999999"),
    ],
)
def test_sizes_beyond_any_frame_are_never_laid_out(tmp_path: Path, old: str, new: str) -> None:
    good = 'BO_ 292 Good: 8 A\n SG_ B : 0|8@1+ (1,0) [0|0] "" A\n\n'
    log = ImportLog()
    text = ONE.format(unit="m").replace("BO_ 291", good + "BO_ 291").replace(old, new, 2)
    try:
        messages = load(tmp_path, text, log)
    except DatabaseError:
        return
    assert all(s.field.start < 100_000 and s.field.length <= 64 for m in messages for s in m.signals)
    assert any("beyond any frame" in note for note in log.notes)


def test_address_254_means_the_group_even_under_a_plain_frame_format(tmp_path: Path) -> None:
    text = (
        HEAD
        + 'BO_ 2566844926 C: 8 A\n SG_ V : 8|16@1+ (1,0) [0|0] "" A\n\n'
        + 'BO_ 2566844672 P: 8 A\n SG_ V : 8|16@1+ (1,0) [0|0] "" A\n\n'
        + 'BA_DEF_ BO_ "VFrameFormat" ENUM "StandardCAN","ExtendedCAN","reserved","J1939PG";\n'
        + 'BA_DEF_DEF_ "VFrameFormat" "J1939PG";\n'
        + 'BA_ "VFrameFormat" BO_ 2566844926 1;\nBA_ "VFrameFormat" BO_ 2566844672 1;\n'
    )
    group, plain = load(tmp_path, text)
    # by its group, unless just this id is in the log: see test_can_j1939
    assert (group.j1939, group.by_exact_id) == (True, True)
    assert (plain.j1939, plain.by_exact_id) == (False, True)
