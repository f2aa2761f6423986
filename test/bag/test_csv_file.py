"""CSV files of any laboratory."""

import gzip

import numpy as np
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from cdp_ident.bag.csv_file import read_columns
from cdp_ident.errors import BagError


def read(tmp_path, text, columns=("0", "1"), **options):
    (tmp_path / "log.csv").write_bytes(text if isinstance(text, bytes) else text.encode())
    return read_columns(tmp_path / "log.csv", columns, **options).tolist()


def test_columns_are_found_by_title_and_by_number(tmp_path):
    text = "time, angle one,angle two\n0,1,2\n0.5,3,4\n"
    assert read(tmp_path, text, ("angle two", "0", "angle one")) == [[2, 0, 1], [4, 0.5, 3]]


@pytest.mark.parametrize(
    "text", ["0;1\n2;3\n", "0\t1\n2\t3\n", "0 1\n2   3\n", "# rig 2\n\n  0, 1\n% later\n2, 3", "\ufeff0,1\r\n2,3\r\n"]
)
def test_the_delimiter_is_found(tmp_path, text):
    assert read(tmp_path, text) == [[0, 1], [2, 3]]


def test_decimal_commas_are_read_where_they_are_said_to_be(tmp_path):
    assert read(tmp_path, "t;a\n0,5;1,25\n", decimal=",") == [[0.5, 1.25]]


def test_a_given_delimiter_is_obeyed(tmp_path):
    assert read(tmp_path, "0|1,5\n", delimiter="|", decimal=",") == [[0, 1.5]]


def test_empty_cells_and_short_rows_are_nan(tmp_path):
    assert np.isnan(read(tmp_path, "0,\n1,2\n3\n")).tolist() == [[False, True], [False, False], [False, True]]


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
        ("t,a\n", ("t", "a"), "titles but no numbers"),
        (b"\xff\xfe\x00\x01", ("0", "1"), "cannot be read as CSV"),
        (gzip.compress(b"0,1\n" * 100, mtime=0)[:20], ("0", "1"), "cannot be read as CSV"),
    ],
)
def test_what_is_wrong_is_said_with_its_place(tmp_path, text, columns, message):
    with pytest.raises(BagError, match=message):
        read(tmp_path, text, columns)


def test_a_missing_file_is_named(tmp_path):
    with pytest.raises(BagError, match=r"nowhere\.csv cannot be read"):
        read_columns(tmp_path / "nowhere.csv", ["0"])


@settings(deadline=None, suppress_health_check=[HealthCheck.function_scoped_fixture])
@given(st.one_of(st.binary(max_size=200), st.text("0123456789.,;\t \"'\n\r-eN#", max_size=200).map(str.encode)))
def test_any_bytes_are_read_or_refused(tmp_path, content):
    try:
        table = read(tmp_path, content)
    except BagError:
        return
    assert all(len(row) == 2 for row in table)
