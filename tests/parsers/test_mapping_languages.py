"""The common quantities in French, Spanish, Italian and Japanese headings, and tables in Shift-JIS."""

from __future__ import annotations

from pathlib import Path

import pytest

from parsers.channels import ChannelInfo
from parsers.load import load_drive
from parsers.mapping import propose_and_say
from parsers.table_names import split_header
from parsers.table_text import find_encoding

KNOWN = {
    "speed": ["Vitesse véhicule [km/h]", "Velocidad del vehículo [km/h]", "Velocità [km/h]", "車速[km/h]", "Speed (OBD)(km/h)"],
    "accel_x": ["Accélération longitudinale [g]", "Aceleración longitudinal [g]", "Accelerazione longitudinale [g]", "前後加速度[G]"],
    "accel_y": ["Accélération transversale [g]", "Aceleración lateral [g]", "Accelerazione trasversale [g]", "横加速度[G]", "左右加速度 [m/s2]"],
    "accel_z": ["Accélération verticale [g]", "Aceleración vertical [g]", "上下加速度[G]"],
    "yaw_rate": [
        "Vitesse de lacet [°/s]", "Vitesse angulaire de lacet [°/s]", "Velocidad de guiñada [°/s]", "Velocità di imbardata [°/s]",
        "velocita_di_imbardata [deg/s]", "ヨーレート[deg/s]", "ﾖｰﾚｰﾄ[deg/s]",
    ],
    "roll_rate": ["Vitesse de roulis [°/s]", "Velocidad de balanceo [°/s]", "Velocità di rollio [°/s]", "ロールレート[deg/s]"],
    "roll": ["Angle de roulis [°]", "Ángulo de balanceo [°]", "Angolo di rollio [°]", "ロール角[deg]"],
    "steering_wheel_angle": ["Angle au volant [°]", "Ángulo del volante [°]", "Angolo volante [°]", "操舵角[deg]", "ハンドル角[deg]"],
    "brake_pressure": ["Pression de frein (bar)", "Presión de freno [bar]", "Pressione freni [bar]", "ブレーキ圧[MPa]", "マスターシリンダ圧[MPa]"],
    "suspension_deflection_fl": [
        "Débattement suspension avant gauche [mm]", "Recorrido suspensión delantera izquierda [mm]",
        "Corsa sospensione anteriore sinistra [mm]", "サスストローク左前[mm]", "サスペンションストロークFL[mm]",
    ],
    "wheel_speed_rr": ["Vitesse roue arrière droite [km/h]", "Velocidad rueda trasera derecha [km/h]", "Velocità ruota posteriore destra [km/h]", "車輪速右後[km/h]", "右後輪速度[km/h]"],
    "gps_speed_2d": ["GPS (2D) [m/s]", "GPS (2D speed) [m/s]", "GPS Speed 2D [m/s]"],
    "gps_speed_3d": ["GPS (3D) [m/s]"],
    "hdop": ["Horizontal Dilution of Precision"],
    "tire_normal_force_rl": ["Fz_RL_daN", "Fz_RL_kgf"],
}  # fmt: skip


def best(header: str) -> list[str]:
    name = split_header(header)
    channel = ChannelInfo(name.name, "t", name.unit, "table", tags={"column": header})
    return list(propose_and_say([channel], None)[0])


@pytest.mark.parametrize(("signal", "header"), [(s, h) for s, names in KNOWN.items() for h in names])
def test_headings_are_known(signal: str, header: str) -> None:
    assert best(header) == [signal]


@pytest.mark.parametrize(
    "header",
    [
        "目標車速[km/h]",
        "実舵角[deg]",
        "前輪舵角[deg]",
        "対地速度[km/h]",
        "横[deg]",
        "ダンパーストローク左前[mm]",
        "Corsa ammortizzatore anteriore sinistro [mm]",
        "Vitesse de consigne [km/h]",
        "Velocidad objetivo [km/h]",
        "Velocità motore [km/h]",
        "v_des_x [m/s]",
        "Course [deg]",
    ],
)
def test_what_is_more_than_a_known_name_is_not(header: str) -> None:
    assert best(header) == []


HEAD = "時間[s],車速[km/h],前後加速度[G],横加速度[G],ヨーレート[deg/s]"


@pytest.mark.parametrize("codec", ["cp932", "utf-8", "utf-8-sig", "utf-16"])
def test_a_japanese_table(codec: str, tmp_path: Path) -> None:
    path = tmp_path / "log.csv"
    rows = "".join(f"{k / 50:.2f},{k % 90},0.{k % 10},0.2,{k % 7}\n" for k in range(400))
    path.write_bytes(f"{HEAD}\n{rows}".encode(codec))
    mapped = {each.signal: each.channel for each in load_drive((path,)).record.mapped}
    assert mapped == {
        "speed": "車速",
        "accel_x": "前後加速度",
        "accel_y": "横加速度",
        "yaw_rate": "ヨーレート",
    }


@pytest.mark.parametrize(
    "text",
    [
        "Zeit [s];Geschwindigkeit;Höhe über NN;Längsbeschl. [m/s²];Gierrate [°/s]",
        "Temps;Vitesse;Accélération latérale;Débattement;Pression maître-cylindre;Référence n° 1",
        "Tiempo;Velocidad de guiñada;Aceleración;Ángulo;Posición;Presión",
    ],
)
def test_western_tables_are_no_shift_jis(text: str) -> None:
    found = find_encoding(f"{text}\r\n0;1;2\r\n".encode("cp1252"))
    assert found is not None
    assert found.codec == "cp1252"
