"""CSV files of any laboratory."""

import gzip

import numpy as np
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from cdp_ident.bag.csv_file import read_table
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


def test_compressed_files_are_read(tmp_path):
    assert read(tmp_path, gzip.compress(b"a,b\n1,2\n")) == [[1, 2]]


@pytest.mark.parametrize(
    ("text", "columns", "message"),
    [
        ("t,a\n0,1\n", ("t", "angle"), "no column 'angle': its columns are t, a"),
        ("0,1\n", ("0", "2"), "no column '2': it has 2 columns and no titles"),
        ("t,a\n0,1\n2,oops\n", ("t", "a"), r"line 3, column 1: 'oops' is not a number"),
        ("# log\nt,a\n\n0,1\n2,oops\n", ("t", "a"), r"line 5"),
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
    assert [title.name for title in found.titles] == (["t", "theta1", "theta2"] if head else [])


@IN_A_FOLDER
@given(st.one_of(st.binary(max_size=200), st.text("0123456789.,;\t \"'\n\r-eN#", max_size=200).map(str.encode)))
def test_any_bytes_are_read_or_refused(tmp_path, content):
    try:
        found = read(tmp_path, content)
    except BagError:
        return
    assert all(len(row) == 2 for row in found)
