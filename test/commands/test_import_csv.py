"""A CSV file becomes a bag in the project's conventions."""

from pathlib import Path

import numpy as np
import pytest
from rosbags.highlevel import AnyReader

from cdp_ident.bag.reader import read_joint_states
from cdp_ident.commands.import_csv import main
from cdp_ident.trial.load import load_trial

MEASURED = Path(__file__).parents[3] / "shared/data/multiarm_free_swing/free_swing_8s_56s_1kHz.csv.gz"
TIME = np.arange(400) * 0.005
THETA = np.column_stack([np.pi + np.sin(5 * TIME), np.pi + 0.5 * np.cos(3 * TIME)])
"""Absolute angles, zero upright."""


@pytest.fixture
def convert(tmp_path):
    """Import columns with options; returns the joints' positions, the stamps and the bag."""

    def run(columns, *options, title="t,a,b,c"):
        np.savetxt(
            tmp_path / "log.csv", np.column_stack(columns), fmt="%.12f", delimiter=",", header=title, comments=""
        )
        assert main([str(tmp_path / "log.csv"), "--out", str(tmp_path / "bag"), *options]) == 0
        recording = read_joint_states(tmp_path / "bag", "joint_states")
        return recording.positions, recording.stamps, recording

    return run


@pytest.mark.parametrize(
    ("angles", "options"),
    [
        (THETA - np.pi, ["--zero", "hanging", "--outer-angle", "absolute"]),
        (np.degrees(THETA), ["--angle-unit", "deg", "--outer-angle", "absolute"]),
        (THETA / (2 * np.pi), ["--angle-unit", "turns", "--outer-angle", "absolute"]),
        (
            THETA / (2 * np.pi) * [8000, 4000],
            ["--angle-unit", "counts", "--counts-per-turn", "8000", "4000", "--outer-angle", "absolute"],
        ),
        (np.column_stack([-THETA[:, 0], THETA[:, 1] - THETA[:, 0]]), ["--inner-sign", "-1"]),
        (np.mod(THETA, 2 * np.pi), ["--outer-angle", "absolute"]),
    ],
)
def test_every_meaning_of_the_angles_ends_in_the_project_s(convert, angles, options):
    positions, _, _ = convert([TIME, angles], *options)
    expected = np.column_stack([THETA[:, 0], THETA[:, 1] - THETA[:, 0]])
    assert np.allclose(positions, expected, atol=1e-9)


def test_the_cart_is_taken_in_metres(convert):
    positions, _, recording = convert(
        [TIME, THETA, 1000 * TIME], "--cart", "c", "--cart-unit", "mm", "--cart-sign", "-1"
    )
    assert recording.joints == ("inner_joint", "outer_joint", "cart_joint")
    assert np.allclose(positions[:, 2], -TIME)


def test_rows_are_chosen_by_time_and_number(convert):
    _, stamps, _ = convert([1000 * TIME, THETA], "--time-unit", "ms", "--from", "0.5", "--to", "1.0", "--every", "5")
    assert len(stamps) == 21
    assert np.array_equal(np.unique(np.diff(stamps)), [25_000_000])


def test_the_start_may_be_given_as_a_date(convert):
    _, stamps, _ = convert([TIME, THETA], "--start-stamp", "2024-05-31T12:00:00.25Z")
    assert stamps[0] == 1_717_156_800_250_000_000
    assert stamps[-1] - stamps[0] == 1_995_000_000


def test_times_since_1970_are_kept(convert):
    _, stamps, _ = convert([TIME + 1_717_156_800, THETA])
    assert np.allclose(stamps, 1_717_156_800_000_000_000 + TIME * 1e9, atol=1000)


def test_the_bag_says_how_it_was_made_and_others_read_it(convert, tmp_path):
    convert([TIME, THETA], "--outer-angle", "absolute")
    with AnyReader([tmp_path / "bag"]) as reader:
        assert reader.message_count == len(TIME)
        assert "--outer-angle absolute" in reader.readers[0].custom_data["made_by"]
        assert len(reader.readers[0].custom_data["source_sha256"]) == 64


def test_rows_without_a_number_are_left_out_and_counted(convert, capsys):
    angles = THETA.copy()
    angles[[3, 7]] = np.nan
    _, stamps, _ = convert([TIME, angles])
    assert len(stamps) == len(TIME) - 2
    assert "2 rows lack a number" in capsys.readouterr().out


@pytest.mark.parametrize(
    ("options", "message"),
    [
        (["--inner", "arm"], "no column 'arm'"),
        (["--angle-unit", "counts"], "needs --counts-per-turn"),
        (["--counts-per-turn", "8000"], "goes with --angle-unit counts"),
        (["--angle-unit", "counts", "--counts-per-turn", "0"], "positive"),
        (["--every", "0"], "--every is 0"),
        (["--from", "100"], "no complete row between"),
        (["--start-stamp", "0"], "later --start-stamp"),
        (["--cart", "3", "--cart-unit", "counts"], "needs --counts-per-metre"),
        (["--time", "b", "--time-unit", "s", "--from", "1e300"], "no complete row"),
    ],
)
def test_bad_input_is_one_line_and_exit_code_2(tmp_path, capsys, options, message):
    np.savetxt(tmp_path / "log.csv", np.column_stack([TIME, THETA, TIME]), delimiter=",", header="t,a,b,c", comments="")
    assert main([str(tmp_path / "log.csv"), "--out", str(tmp_path / "bag"), *options]) == 2
    error = capsys.readouterr().err
    assert error.count("\n") == 1
    assert message in error
    assert not (tmp_path / "bag").exists()


def test_an_existing_bag_is_not_overwritten(convert, tmp_path, capsys):
    convert([TIME, THETA])
    assert main([str(tmp_path / "log.csv"), "--out", str(tmp_path / "bag")]) == 2
    assert "not overwritten" in capsys.readouterr().err


@pytest.mark.skipif(not MEASURED.exists(), reason="the measured swing is not beside the repository")
def test_a_measured_swing_becomes_a_bag_and_wrong_conventions_are_noticed_at_once(tmp_path, capsys):
    columns = ["--time", "time_s", "--inner", "theta1_rad", "--outer", "theta2_rad", "--every", "5"]
    assert main([str(MEASURED), "--out", str(tmp_path / "right"), *columns, "--outer-angle", "absolute"]) == 0
    assert "warning" not in capsys.readouterr().out
    trial = load_trial(tmp_path / "right")
    assert trial.duration == pytest.approx(47.995)
    assert main([str(MEASURED), "--out", str(tmp_path / "wrong"), *columns]) == 0
    assert "outer_angle: absolute leaves" in capsys.readouterr().out
