# Copyright 2026 cdp_ident maintainers
# SPDX-License-Identifier: Apache-2.0
"""CSV files of any laboratory, and what the titles of their columns say."""

import contextlib
import gzip
import io
import tracemalloc

import numpy as np
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st
from scipy.io import savemat

from cdp_ident.bag.csv_file import read_table
from cdp_ident.bag.csv_titles import Title, may_be_angles, roles, torque_unit, torques
from cdp_ident.errors import BagError

IN_A_FOLDER = settings(suppress_health_check=[HealthCheck.function_scoped_fixture])


def table(tmp_path, text, **options):
    (tmp_path / "log.csv").write_bytes(text if isinstance(text, bytes) else text.encode())
    return read_table(tmp_path / "log.csv", **options)


def read(tmp_path, text, columns=("0", "1"), **options):
    found = table(tmp_path, text, **options)
    return np.column_stack([found.column(found.place(column)) for column in columns]).tolist()


def test_columns_are_found_by_title_and_by_number(tmp_path):
    text = "time, angle one,angle two [deg]\n0,1,2\n0.5,3,4\n"
    assert read(tmp_path, text, ("angle two", "0", "angle one")) == [[2, 0, 1], [4, 0.5, 3]]
    assert read(tmp_path, text, ("angle two [deg]", "2")) == [[2, 2], [4, 4]]


@pytest.mark.parametrize(
    "text",
    [
        "0;1\n2;3\n",
        "0\t1\n2\t3\n",
        "0 1\n2   3\n",
        "0|1\n2|3\n",
        "# rig 2\n\n  0, 1\n% later\n2, 3",
        "\ufeff0,1\r\n2,3\r\n",
        "0,0;1\n2;3,0\n",
        "0,0 1\n2 3,0\n",
        '"0,0","1"\n"2","3,0"\n',
        "0,1\n2,3\n".encode("utf-16"),
    ],
)
def test_what_parts_columns_and_decimals_is_found(tmp_path, text):
    assert read(tmp_path, text) == [[0, 1], [2, 3]]


def test_what_is_given_is_obeyed(tmp_path):
    assert read(tmp_path, "0:1,5\n", delimiter=":", decimal=",") == [[0, 1.5]]
    assert read(tmp_path, "0,1;2,3\n", delimiter=";") == [[0.1, 2.3]]


@pytest.mark.parametrize(
    ("head", "titles"),
    [
        ("t,phi1 [deg],phi2 [deg]\n", [("t", ""), ("phi1", "deg"), ("phi2", "deg")]),
        ("# t_s, phi1 (deg), phi2 (°)\n", [("t", "s"), ("phi1", "deg"), ("phi2", "deg")]),
        ("rig 2, 2024\nrate: 200 Hz\n\nt,phi1,phi2\nms,rad,rad\n", [("t", "ms"), ("phi1", "rad"), ("phi2", "rad")]),
        ("%t [s]  phi1/rad  phi2/rad\n", [("t", "s"), ("phi1", "rad"), ("phi2", "rad")]),
        ("s,deg,deg\n", [("", "s"), ("", "deg"), ("", "deg")]),
    ],
)
def test_titles_and_units_are_found_before_the_numbers(tmp_path, head, titles):
    found = table(tmp_path, head + "0,1,2\n3,4,5\n")
    assert [(title.name, title.unit) for title in found.titles] == titles
    assert found.values.tolist() == [[0, 1, 2], [3, 4, 5]]


def test_it_says_how_the_file_is_written(tmp_path):
    found = table(tmp_path, "rig 2\nt;a\n0,5;1,25\n1;2\n")
    assert found.format == "2 rows of 2 columns parted by semicolons, decimal commas, titles in line 2"


def test_empty_cells_and_short_rows_and_words_for_nothing_are_nan(tmp_path):
    found = read(tmp_path, "0,\n1,2\n3\nNaN,n/a\n")
    assert np.isnan(found).tolist() == [[False, True], [False, False], [False, True], [True, True]]


def test_a_column_of_words_harms_nobody_who_does_not_want_it(tmp_path):
    text = "t,state,a\n0,up,1\n1,down,2\n2,up,3\n"
    assert read(tmp_path, text, ("t", "a")) == [[0, 1], [1, 2], [2, 3]]
    with pytest.raises(BagError, match="line 2, column 1: 'up' is not a number"):
        read(tmp_path, text, ("t", "state"))


@pytest.mark.parametrize(
    ("text", "columns", "message"),
    [
        ("t,a\n0,1\n", ("t", "angle"), "no column 'angle': its columns are t, a"),
        ("0,1\n", ("0", "2"), "no column '2': its columns are 2 without titles"),
        ("t,a\n0,1\n2,1.2.3\n", ("t", "a"), r"line 3, column 1: '1\.2\.3' is not a number"),
        ("# log\nt,a\n\n0,1\n2,1.2.3\n", ("t", "a"), r"line 5"),
        ("", ("0", "1"), "is empty"),
        ("t,a\n", ("t", "a"), "no numbers in columns"),
        ("# t,a\n", ("t", "a"), "comments but no numbers"),
        (b"\xff\xfe\x00", ("0", "1"), "cannot be read as CSV"),
        (gzip.compress(b"0,1\n" * 100, mtime=0)[:20], ("0", "1"), "cannot be read as CSV"),
    ],
)
def test_what_is_wrong_is_said_with_its_place(tmp_path, text, columns, message):
    with pytest.raises(BagError, match=message):
        read(tmp_path, text, columns)


def test_a_missing_file_is_named(tmp_path):
    with pytest.raises(BagError, match=r"nowhere\.csv cannot be read"):
        read_table(tmp_path / "nowhere.csv")


@pytest.mark.parametrize(
    "text",
    [
        "Rig 2,,\nMass,0.11,\nDate,2024-05-31,\n,,\nTime [s],a,b\n0,1,2\n0.5,3,4\n",
        "Time [s],a,b\n0,1,2\nPaused by the operator\n0.5,3,4\n",
        "Time [s],a,b\n0,1,2\nTime [s],a,b\n0.5,3,4\n",
        "Time [s],a,b\n0,1,2\nmark,7,\n0.5,3,4\n",
    ],
)
def test_lines_of_words_before_and_between_the_numbers_are_no_rows(tmp_path, text):
    found = table(tmp_path, text)
    assert [title.text for title in found.titles] == ["Time [s]", "a", "b"]
    assert found.values.tolist() == [[0, 1, 2], [0.5, 3, 4]]
    between = len(text.splitlines()) > 3 and text.startswith("Time")
    assert ("lines that are no rows are left out: 1, first line 3" in "".join(found.notes)) == between


@pytest.mark.parametrize("word", ["---", "ERR", "TRUE", "*", "off", "#N/A", "1.#QNAN"])
def test_a_word_among_numbers_is_a_missing_reading_and_counted(tmp_path, word):
    found = table(tmp_path, f"t,a,b\n0,1,2\n0.5,{word},3\n1,4,5\n")
    assert np.isnan(found.column(1)).tolist() == [False, True, False]
    assert found.column(2).tolist() == [2, 3, 5]
    if "#" not in word:
        assert found.notes == (f"words in place of numbers are missing readings: 1, first line 3, {word!r}",)


def test_numbers_in_a_preamble_are_no_sample_and_hide_no_titles(tmp_path):
    found = table(tmp_path, "1,2,3\nL,0.4,m\nTime [s],a,b\n0,1,2\n0.5,3,4\n")
    assert [title.text for title in found.titles] == ["Time [s]", "a", "b"]
    assert found.values.tolist() == [[0, 1, 2], [0.5, 3, 4]]
    assert "no rows are left out: 1, first line 1" in found.notes[0]


def test_what_a_device_says_when_it_starts_is_no_title(tmp_path):
    boot = "rst:0x1 (POWERON)\nclk:0x00,q:0x00,d:0x00\nmode:DIO, clock div:1\nentry 0x400805f0\nStarting...\n"
    found = table(tmp_path, boot + "0.000,2.4,2.1\n0.005,2.4,2.1\n")
    assert not any(title.text for title in found.titles)
    assert len(found.values) == 2


@pytest.mark.parametrize(
    ("first", "second", "seconds"),
    [
        ("2024-05-31T12:00:00.005", "2024-05-31T12:00:01", 1717156800.005),
        ("2024-05-31 14:00:00.005+02:00", "2024-05-31 14:00:01+02:00", 1717156800.005),
        ("2024-05-31 09:30:00.005-0230", "2024-05-31 09:30:01-0230", 1717156800.005),
        ("5/31/2024 12:59:55.005 PM", "5/31/2024 12:59:56 PM", 46795.005),
        ("12:00:05.005 am", "12:00:06 am", 5.005),
        ("10:00:05:005", "10:00:06:000", 36005.005),
        ("00:55.005", "00:56.0", 55.005),
        ("2024-05-31T12:00:00.005000123Z", "2024-05-31T12:00:01Z", 1717156800.005),
        ("12:00:00.005", "12:00:01", 43200.005),
        ("20240531T120000.005Z", "20240531T120001Z", 1717156800.005),
        ("20240531T140000.005+0200", "20240531T140001+02:00", 1717156800.005),
    ],
)
def test_dates_and_times_of_day_are_seconds(tmp_path, first, second, seconds):
    (start, _), (stop, _) = read(tmp_path, f"t,a\n{first},1\n{second},2\n")
    assert start == pytest.approx(seconds, abs=1e-6)
    assert stop == pytest.approx(seconds + 0.995, abs=1e-6)


@pytest.mark.parametrize(
    ("beginning", "again", "row"),
    [
        ("t,a,b\n", "t,a,b\n", "0.2,5,6"),
        ("t,a,b\n", "t,b,a\n", "0.2,6,5"),
        ("t,a,b\n", "# t,b,a\n", "0.2,6,5"),
        ("t,a [rad],b [deg]\n", "b [deg],t,a [rad]\n", "6,0.2,5"),
        ("t,a,b\ns,rad,rad\n", "s,rad,rad\n", "0.2,5,6"),
        ("t,a,b\n", "paused,by,hand\n", "0.2,5,6"),
        ("t,a,b\n", "t,b,a\n0.2,6,5\nt,a,b\n", "0.3,7,8"),
    ],
)
def test_columns_are_those_of_the_last_titles(tmp_path, beginning, again, row):
    found = table(tmp_path, f"{beginning}0.0,1,2\n0.1,3,4\n{again}{row}\n")
    assert found.values[:3].tolist() == [[0.0, 1.0, 2.0], [0.1, 3.0, 4.0], [0.2, 5.0, 6.0]]
    assert found.values[3:].tolist() in ([], [[0.3, 7.0, 8.0]])
    assert any("in the order that it tells" in note for note in found.notes) == ("b,a" in again or "b [deg],t" in again)


@pytest.mark.parametrize("again", ["t,a [deg],b", "t,b,c", "t,a,c,b", "t,b", "# t,a [deg],b"])
def test_other_titles_between_rows_are_refused_with_their_line(tmp_path, again):
    with pytest.raises(BagError, match=r"line 4 has other titles than line 1: .*part the file there"):
        read(tmp_path, f"t,a [rad],b [rad]\n0.0,1,2\n0.1,3,4\n{again}\n0.2,5,6\n")


def test_other_units_between_rows_are_refused_with_their_line(tmp_path):
    with pytest.raises(BagError, match="line 5 has other titles"):
        read(tmp_path, "t,a,b\ns,rad,rad\n0.0,1,2\n0.1,3,4\ns,deg,deg\n0.2,5,6\n")


def test_no_date_is_a_word(tmp_path):
    with pytest.raises(BagError, match="'2024-13-31 12:00:00' is not a number"):
        read(tmp_path, "t,a\n2024-12-31 12:00:00,1\n2024-13-31 12:00:00,2\n")


def test_joint_states_that_ros2_topic_echo_wrote_have_their_joints_names(tmp_path):
    row = "{},{},,cart_joint,inner_joint,outer_joint,0.0,{},{},0.1,0.2,0.3,0.0,0.0,0.0\n"
    found = table(tmp_path, "".join(row.format(1700000000, nanosec, 1.5, -0.5) for nanosec in (5, 5_000_005)))
    assert [title.text for title in found.titles[6:10]] == [
        "cart_joint",
        "inner_joint",
        "outer_joint",
        "cart_joint velocity",
    ]
    assert found.column(found.place("inner_joint")).tolist() == [1.5, 1.5]
    assert found.titles[0].text == "sec"
    without = table(tmp_path, "".join(f"{row},{5 * row},{row / 10},{row / 7},{row / 3}\n" for row in range(9)))
    assert [title.text for title in without.titles] == [""] * 5


def matlab(contents, compressed):
    stream = io.BytesIO()
    savemat(stream, contents, do_compression=compressed)
    return stream.getvalue()


@pytest.mark.parametrize(
    ("content", "words"),
    [
        (b"#ROSBAG V2.0\n" + bytes(100), "rosbags-convert --src .*log.csv --dst"),
        (b"\x89HDF\r\n" + bytes(100), "writematrix"),
        (b"PK\x03\x04" + bytes(100), "save the sheet as CSV"),
        ("A message was lost!!!\n---\nheader:\n  stamp:\n    sec: 1\n" * 9, "what `ros2 topic echo` prints"),
        *[
            (matlab(contents, compressed), r"is a file of MATLAB: there, `writematrix\(.*scipy\.io\.loadmat")
            for contents in ({"log": np.ones((9, 3))}, {"log": {"time": np.ones(9), "data": np.ones((9, 2))}})
            for compressed in (False, True)
        ],
    ],
    ids=["ROS 1", "HDF5", "a spreadsheet", "topic echo", *(f"MATLAB {k}" for k in range(4))],
)
def test_files_of_other_kinds_get_the_line_that_converts_them(tmp_path, content, words):
    with pytest.raises(BagError, match=words):
        table(tmp_path, content)


@pytest.mark.parametrize(
    ("text", "most"),
    [
        ("1,2\n" * 20_000 + 5000 * "," + "\n", 4.0),
        ("1,2\n" * 20_000 + 200_000 * "," + "\n", 4.0),
        ("a,b,c\n" + "1," * 30_000 + "1\n" + "1,2,3\n" * 70_000, 12.0),
        ("a,b,c\n" + ("1," * 30_000 + "1\n") * 2 + "1,2\n" * 70_000, 12.0),
        ("0.005,1.234567,-2.345678\n" * 40_000, 5.0),
        ("1," * 500_000, 4.0),
    ],
    ids=["a wide row", "a wider row", "a wide row at first", "two wide rows at first", "ordinary rows", "one line"],
)
def test_memory_is_a_small_multiple_of_the_file(tmp_path, text, most):
    tracemalloc.start()
    with contextlib.suppress(BagError):
        table(tmp_path, text)
    peak = tracemalloc.get_traced_memory()[1]
    tracemalloc.stop()
    assert peak < most * len(text) + 3e6


@IN_A_FOLDER
@given(
    rows=st.lists(st.lists(st.integers(-99999, 99999), min_size=3, max_size=3), min_size=2, max_size=20),
    form=st.sampled_from([(",", "."), (";", "."), ("\t", "."), (" ", "."), (";", ","), ("\t", ","), (" ", ",")]),
    head=st.sampled_from(
        ["", "t{0}theta1{0}theta2\n", "# t{0}theta1{0}theta2\n", "Log of\nt{0}theta1{0}theta2\ns{0}deg{0}deg\n"]
    ),
    end=st.sampled_from(["\n", "\r\n"]),
    compressed=st.booleans(),
)
def test_however_it_is_written_the_same_numbers_are_read(tmp_path, rows, form, head, end, compressed):
    delimiter, decimal = form
    lines = [delimiter.join(f"{value / 100:.2f}".replace(".", decimal) for value in row) for row in rows]
    text = (head.format(delimiter) + "\n".join(lines) + "\n").replace("\n", end).encode()
    found = table(tmp_path, gzip.compress(text) if compressed else text)
    assert np.array_equal(found.values, np.array(rows) / 100)
    assert [title.name for title in found.titles] == (["t", "theta1", "theta2"] if head else [""] * 3)


@IN_A_FOLDER
@given(st.one_of(st.binary(max_size=200), st.text("0123456789.,;\t \"'\n\r-eN#", max_size=200).map(str.encode)))
def test_any_bytes_are_read_or_refused(tmp_path, content):
    try:
        found = read(tmp_path, content)
    except BagError:
        return
    assert all(len(row) == 2 for row in found)


@pytest.mark.parametrize(
    "before",
    [
        "scorer,DLC,DLC,DLC,DLC\nbodyparts,joint,joint,tip,tip\ncoords,x,y,x,y\n",
        "frame,joint,,tip,\nframe,x,y,x,y\n",
    ],
)
def test_titles_that_stand_twice_belong_to_what_stands_above(tmp_path, before):
    found = table(tmp_path, f"{before}0,1,2,3,4\n1,1,2,3,5\n")
    assert [title.text for title in found.titles[1:]] == ["joint x", "joint y", "tip x", "tip y"]


def test_a_cell_with_a_spreadsheet_s_error_is_missing(tmp_path):
    assert np.isnan(read(tmp_path, "t,a\n0,1\n1,#DIV/0!\n2,3\n")[1][1])


@pytest.mark.parametrize(
    ("text", "name", "unit"),
    [
        ("theta1 [deg]", "theta1", "deg"),
        ("Winkel 1 (°)", "Winkel 1", "deg"),
        ("theta1/rad", "theta1", "rad"),
        ("time_ms", "time", "ms"),
        ("x in mm", "x", "mm"),
        ("theta_1", "theta_1", ""),
        ("cart_position", "cart_position", ""),
        ("torque [N m]", "torque", "N m"),
        ("tau1 [mNm]", "tau1", "mN m"),
        ("t", "t", ""),
    ],
)
def test_a_title_is_a_name_and_a_unit(text, name, unit):
    assert (Title.of(text).name, Title.of(text).unit) == (name, unit)


@pytest.mark.parametrize(
    ("titles", "found"),
    [
        ("t theta1 theta2", {"time": 0, "inner": 1, "outer": 2}),
        ("Time q0 q1 dq0 dq1", {"time": 0, "inner": 1, "outer": 2}),
        ("time pos1 pos2 vel1 vel2 tau1 tau2", {"time": 0, "inner": 1, "outer": 2}),
        ("theta2_rad theta1_rad time_s", {"time": 2, "inner": 1, "outer": 0}),
        ("stamp cart_position inner_joint outer_joint", {"time": 0, "cart": 1, "inner": 2, "outer": 3}),
        ("theta1 phi1 theta2", {"outer": 2}),
        ("one two three", {}),
        (
            "frame pivot_x pivot_y joint_x joint_y tip_x tip_y",
            {"frame": 0, "pivot_x": 1, "pivot_y": 2, "joint_x": 3, "joint_y": 4, "tip_x": 5, "tip_y": 6},
        ),
        (
            "x0 y0 x1 y1 x2 y2",
            {"pivot_x": 0, "pivot_y": 1, "joint_x": 2, "joint_y": 3, "tip_x": 4, "tip_y": 5},
        ),
    ],
)
def test_titles_tell_what_columns_are(titles, found):
    assert roles([Title.of(text) for text in titles.split()]) == found


@pytest.mark.parametrize(
    ("titles", "angles"),
    [
        ("packet,time_us,angle", [2]),
        ("pwm,time_us,position,angle", [3]),
        ("time,pend_duty,pend,dutycycle,pwmLeft,motorPWM", [2]),
        ("t,theta,theta_sim", [1]),
        ("t,measured [deg],model [deg]", [1]),
        ("time,tip x,tip y", []),
        ("time,first,second,velocity,motorCurrent", [1, 2]),
        ("stamp,alpha,beta", [1, 2]),
        ("Time,Model Root/Encoder/phi1,Model Root/Encoder/phi2,Model Root/Motor/u", [1, 2]),
        ("t,position [m],angle,speed", [2]),
        ("t,arm [rad],arm2 [rad],arm [rad/s]", [1, 2]),
    ],
)
def test_titles_tell_which_columns_may_be_angles(titles, angles):
    assert may_be_angles([Title.of(text) for text in titles.split(",")]) == angles


def test_torques_of_both_joints_are_found_for_each_kind():
    titles = "time pos1 pos2 tau_con1 tau_con2 tau_meas2 tau_meas1 tau_fric1 inner_command_Nm outer_command_Nm torque"
    assert torques([Title.of(text) for text in titles.split()]) == [(3, 4), (6, 5), (8, 9), (7, None)]
    assert torques([Title.of(f"/joint_states/{joint}_joint/effort") for joint in ("outer", "inner")]) == [(1, 0)]
    assert torques([Title.of(text) for text in ["t", "u1", "motorCurrent2", "pwm"]]) == [(1, None), (None, 2)]
    for of_joints in (
        "tau_shoulder tau_elbow",
        "shoulder_torque elbow_torque",
        "upper_tau lower_tau",
        "effort1 effort2",
    ):
        assert torques([Title.of(text) for text in ("t", *of_joints.split())]) == [(1, 2)]
    assert torques([Title.of(text) for text in ("t", "I1 (A)", "I2 (A)", "tau_elbow", "tau_shoulder")]) == [
        (1, 2),
        (4, 3),
    ]


@pytest.mark.parametrize(
    ("title", "unit"),
    [
        *((text, 1.0) for text in ("tau1", "tau1 [N m]", "shoulder_torque", "inner_current_torque_Nm", "effort2")),
        ("tau1 [mNm]", 1e-3),
        *((text, None) for text in ("current1 [A]", "motor1_current", "pwm1", "u1", "I1 (A)", "tau1 [%]")),
    ],
)
def test_what_torques_are_in(title, unit):
    assert torque_unit(Title.of(title)) == unit
