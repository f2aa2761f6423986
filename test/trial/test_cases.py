# Copyright 2026 cdp_ident maintainers
# SPDX-License-Identifier: Apache-2.0
"""Recordings of the kinds that were once answered wrongly: as much of each is used as there is."""

import re
from pathlib import Path

import numpy as np
import pytest
from rich.console import Console
from scipy.interpolate import CubicSpline

from cdp_ident.bag.reader import read_joint_states
from cdp_ident.commands.import_csv import main as import_csv
from cdp_ident.errors import BagError, TrialError
from cdp_ident.pipeline.identifier import Identifier, Request
from cdp_ident.trial.load import load_trial
from cdp_ident.trial.options import TrialOptions

CASES = Path(__file__).parents[3] / "shared" / "cases"
DRIVEN = CASES.parent / "data" / "dfki_driven"
COUNT = 2 * np.pi / 8000
WHOLE = Path(__file__).parents[2] / "bags" / "swing_wide"

NEEDS_CASES, NEEDS_DRIVEN = (
    pytest.mark.skipif(not folder.exists(), reason=f"the recordings are not at {folder}") for folder in (CASES, DRIVEN)
)


@NEEDS_CASES
@pytest.mark.parametrize(
    ("case", "least", "most", "note"),
    [
        ("appledouble/c_macos", 11.8, 11.9, ""),
        ("appledouble/c_macos_db", 11.8, 11.9, ""),
        ("split_one_bad_file/split_empty", 11.8, 11.9, "nothing more is read of"),
        ("split_one_bad_file/c_split_zeros", 3.0, 11.9, "nothing more is read of"),
        ("split_one_bad_file/c_split_magic", 3.0, 11.9, "nothing more is read of"),
        ("split_one_bad_file/c_split_db_empty", 3.0, 11.9, "nothing more is read of"),
        ("split_one_bad_file/c_split_db_broken", 3.0, 11.9, "nothing more is read of"),
        ("clock_set_back/f_back100", 7.7, 11.9, "the clock was set back by 99.995 s"),
        ("clock_set_back/f_back100_early", 7.7, 11.9, "the clock was set back by 99.995 s"),
        ("clock_set_back/f_future_first", 11.7, 11.9, "the clock was set back by 3600.0"),
        ("clock_set_back/f_simreset", 3.0, 11.9, "the clock was set back by"),
    ],
)
def test_a_bag_gives_as_long_a_swing_as_there_is_and_says_what_is_missing(case, least, most, note):
    trial = load_trial(CASES / case)
    assert least <= trial.duration <= most
    assert note in "; ".join(trial.notes)


@NEEDS_CASES
@pytest.mark.parametrize(
    ("case", "note"),
    [
        ("held_positions/b_held_both", "readings of inner_joint repeat 4 times in motion: 1951 repetitions"),
        ("bursts/b_zero_batch", "samples came in bursts of about 4 every 19.8 ms"),
        ("bursts/c_burst16", "samples came in bursts of about 3.1 every 15.7 ms"),
        ("bursts/c_burst16j", "samples came in bursts of about 2.9"),
        ("bursts/c_burst50", "samples came in bursts of about 9.7 every 48.7 ms"),
        ("useless_stamps/b_seconly", "the stamps are whole seconds: the time of receipt is used"),
        ("useless_stamps/b_f32epoch", "the stamps are whole seconds: the time of receipt is used"),
        ("useless_stamps/b_msec", "the stamps hold milliseconds where nanoseconds belong"),
        ("useless_stamps/b_usec", "the stamps hold microseconds where nanoseconds belong"),
        ("one_joint_a_message/b_each_same", "joints are measured at times of their own"),
        ("one_joint_a_message/b_each_diff", "joints are measured at times of their own"),
        (
            "two_publishers/b_zeros50",
            "a second publisher that never moves says 0 and 0 on the same topic: its 651 messages",
        ),
        ("two_publishers/b_zeros200", "a second publisher that never moves"),
        ("two_publishers/b_zeros_samestamp_first", "a second publisher that never moves"),
    ],
)
def test_the_motion_is_that_of_the_bag_that_the_case_was_made_from(case, note):
    trial = load_trial(CASES / case)
    assert note in "; ".join(trial.notes)
    assert trial.duration == pytest.approx(11.87, abs=0.03)
    assert off(trial) < 0.5e-3


@NEEDS_CASES
@pytest.mark.parametrize(
    ("case", "settings", "whose"),
    [
        ("b_deg", {"inner_unit": "degrees", "outer_unit": "degrees"}, "both joints are in degrees"),
        ("c_deg_hang", {"inner_unit": "degrees", "outer_unit": "degrees", "zero": "hanging"}, "both joints are"),
        ("c_deg_outer", {"outer_unit": "degrees"}, "the outer joint is in degrees"),
    ],
)
def test_degrees_are_named_with_the_settings_that_put_them_right(case, settings, whose):
    with pytest.raises(
        TrialError, match=f"{whose}.*{' and '.join(f'{key}: {value}' for key, value in settings.items())}"
    ):
        load_trial(CASES / "degrees" / case)
    assert off(load_trial(CASES / "degrees" / case, TrialOptions(**settings))) < 1e-6


@NEEDS_CASES
@pytest.mark.parametrize(
    ("case", "cause"),
    [
        ("two_publishers/b_tworigs", "alternate between two motions"),
        (
            "empty_topic/emptytopic",
            "there is no message on /joint_states .* joint states are on /rig1/joint_states: name",
        ),
        ("empty_topic/emptyonly", "there is no message on /joint_states"),
        ("ros1_encoding/ros1mcap", "2602 are encoded as ros1: expected cdr; .*rosbags-convert"),
        ("ros1_encoding/jsonros", "2602 are encoded as json: expected cdr"),
    ],
)
def test_what_cannot_be_used_is_refused_with_its_cause(case, cause):
    with pytest.raises((BagError, TrialError), match=cause):
        load_trial(CASES / case)


def off(trial):
    """How far a trial is from that of the bag that all are made from [rad rms], but for times that are late by much."""
    whole = load_trial(WHOLE)
    motion = CubicSpline(whole.time + whole.start, whole.theta)
    errors = []
    for late in np.arange(-0.06, 0.03, 0.125e-3):
        times = trial.time + trial.start - late
        inside = (times > whole.start) & (times < whole.start + whole.duration)
        errors.append(np.sqrt(np.mean((trial.theta[inside] - motion(times[inside])) ** 2, axis=0)).max())
    return min(errors)


@pytest.mark.parametrize("rates", [(90, 70), (95, 105), (70, 70), (130, 90)])
def test_encoders_that_are_read_at_rates_of_their_own_have_times_of_their_own(make_bag, rates):
    def hold(positions):
        time = 0.005 * np.arange(len(positions))
        for column, rate, phase in zip(positions.T, rates, (0.2, 0.2 if rates[0] == rates[1] else 0.5), strict=True):
            read = np.maximum(np.floor(time * rate + phase) - phase, 0.0) / rate
            column[:] = np.round(CubicSpline(time, column)(read) / COUNT) * COUNT

    trial = load_trial(with_changes(make_bag, hold))
    assert off(trial) < 1e-3
    assert "the times of samples jitter" in "; ".join(trial.notes)


def test_a_second_publisher_that_hangs_is_left_out_whatever_the_order_of_messages(make_bag):
    whole = read_joint_states(WHOLE, "joint_states")
    positions = whole.positions[:, [whole.joints.index(joint) for joint in ("inner_joint", "outer_joint")]]
    both = np.concatenate([positions, np.broadcast_to([np.pi, 0.0], positions.shape)])
    stamps = np.concatenate([whole.stamps, whole.stamps + 2_500_000])
    # A recorder that stalls writes what one of both said meanwhile, then what the other did.
    passed, stall = stamps - stamps[0], 120_000_000
    written = np.where(passed // stall % 5 == 0, passed // stall * stall, passed)
    order = np.lexsort([stamps, np.arange(len(both)) >= len(positions), written])
    trial = load_trial(make_bag(stamps[order], both[order]))
    assert off(trial) < 1e-6
    assert trial.duration == pytest.approx(11.87, abs=0.03)


@pytest.mark.parametrize(("late", "every"), [(10.0, 1), (15.0, 1), (20.0, 1), (10.3, 1), (10.0, 2), (50.0, 1)])
def test_what_is_said_again_a_little_later_is_left_out(make_bag, late, every):
    whole = read_joint_states(WHOLE, "joint_states")
    positions = whole.positions[:, [whole.joints.index(joint) for joint in ("inner_joint", "outer_joint")]]
    stamps = np.concatenate([whole.stamps, whole.stamps[::every] + round(1e6 * late)])
    order = np.argsort(stamps, kind="stable")
    trial = load_trial(make_bag(stamps[order], np.concatenate([positions, positions[::every]])[order]))
    assert "say later what others said before (a second publisher, a relay?)" in "; ".join(trial.notes)
    assert trial.duration == pytest.approx(11.87, abs=0.03)
    motion = load_trial(WHOLE)
    same = np.isin(np.round(1e6 * (trial.time + trial.start)), np.round(1e6 * (motion.time + motion.start)))
    assert np.mean(same) > 0.98
    assert off(trial) < 0.1e-3


def with_changes(make_bag, change):
    """A bag like that of which the motion is known, with other readings (n, 2)."""
    whole = read_joint_states(WHOLE, "joint_states")
    positions = whole.positions[:, [whole.joints.index(joint) for joint in ("inner_joint", "outer_joint")]]
    change(positions)
    return make_bag(whole.stamps, positions)


@pytest.mark.parametrize(("joints", "lasts"), [([0], 20), ([1], 8), ([0, 1], 5), ([0, 1], 40)])
def test_readings_of_a_sensor_that_freezes_are_no_measurements(make_bag, joints, lasts):
    def freeze(positions):
        for at in (400, 900, 1300, 1900):
            positions[at : at + lasts, joints] = positions[at, joints]

    trial = load_trial(with_changes(make_bag, freeze))
    assert off(trial) < 0.5e-3
    assert trial.duration == pytest.approx(11.87, abs=0.03)
    assert re.search("joint stand still [234] times in the midst of motion", "; ".join(trial.notes))


@pytest.mark.parametrize(("joint", "counts"), [("outer", 20), ("outer", 400), ("inner", -100)])
def test_lost_counts_cost_nothing_of_the_recording_and_are_kept(make_bag, joint, counts):
    places, size = (700, 1300, 1900), counts * 2 * np.pi / 8000

    def lose(positions):
        for at in places:
            positions[at:, int(joint == "outer")] += size

    whole, trial = load_trial(WHOLE), load_trial(with_changes(make_bag, lose))
    assert np.array_equal(trial.time, whole.time)
    lost = size * np.searchsorted(places, np.round((trial.time + trial.start) / 0.005), side="right")
    assert trial.theta - whole.theta == pytest.approx(np.outer(lost, [joint == "inner", 1.0]), abs=1e-6)
    assert re.search(rf"readings of the {joint} joint step by .* at 3.500 s", "; ".join(trial.notes))


@pytest.mark.parametrize("value", [9999.0, -1.0, 0.0])
def test_a_number_in_place_of_missing_readings_is_left_out_and_no_wrap(make_bag, value):
    def lose(positions):
        positions[[300, 500, 801, 1100, 1500, 1800, 2100]] = value

    trial = load_trial(with_changes(make_bag, lose))
    assert off(trial) < 1e-6
    assert "7 outliers" in "; ".join(trial.notes)
    assert "wrap" not in "; ".join(trial.notes)


@pytest.mark.parametrize("value", [9999.0, -32768.0, 50.0])
def test_a_number_that_often_stands_for_missing_readings_is_none(make_bag, value):
    def lose(positions):
        positions[5::20, 0], positions[::33] = value, value

    trial = load_trial(with_changes(make_bag, lose))
    assert off(trial) < 1e-6
    assert not trial.outliers
    assert f"readings of outer_joint that are {value:g} stand for missing ones" in "; ".join(trial.notes)


@NEEDS_CASES
@pytest.mark.parametrize(("dump", "said"), [("dump_a", ""), ("dump_b", "m1, groups.A23_over_A22, std.m1: results")])
def test_a_dump_of_identify_s_parameters_is_its_configuration(capsys, dump, said):
    request = Request((), (), None, None, None, CASES / "param_dump" / f"{dump}.yaml", False)
    settings = Identifier(request, Console(), Console()).settings({})
    assert settings.identify.prior.constant("L") == 0.4
    assert capsys.readouterr().out.startswith(said)


@NEEDS_CASES
@pytest.mark.parametrize(
    ("file", "columns", "words"),
    [
        ("pendule_pi_single", [], "as those of one pendulum do.* packet, time_us, angle"),
        ("pendule_pi_single", ["packet", "angle"], "the inner joint does not turn.* packet, time_us, angle"),
        ("pendule_pi_cart_single", [], "as those of one pendulum do.* pwm, time_us, position, angle"),
        ("pendule_pi_cart_single", ["angle", "position"], "nothing to do with each other"),
        ("pendule_pi_cart_single", ["pwm", "angle"], "the inner joint does not turn"),
    ],
)
def test_what_is_no_free_double_pendulum_is_refused_in_one_line(tmp_path, capsys, file, columns, words):
    named = [word for pair in zip(["--inner", "--outer"], columns, strict=False) for word in pair]
    options = ["--out", str(tmp_path / "bag"), "--zero", "hanging", *named, *(["--angle-unit", "rad"] if named else [])]
    assert import_csv([str(CASES / "not_a_double_pendulum" / f"{file}.csv.gz"), *options]) == 2
    (line,) = capsys.readouterr().err.splitlines()
    assert re.search(words, line)


@pytest.mark.parametrize(
    ("file", "columns"),
    [
        pytest.param(CASES / "not_a_double_pendulum" / "dfki_C1_driven.csv.gz", [], marks=NEEDS_CASES),
        pytest.param(DRIVEN / "run1.csv.gz", [], marks=NEEDS_DRIVEN),
        pytest.param(
            DRIVEN / "run2.csv.gz",
            ["--inner", "inner_rad", "--outer", "outer_rad", "--angle-unit", "rad"],
            marks=NEEDS_DRIVEN,
        ),
    ],
)
def test_joints_that_motors_drive_are_taken_with_their_torques(tmp_path, capsys, file, columns):
    assert import_csv([str(file), "--out", str(tmp_path / "bag"), "--zero", "hanging", *columns]) == 0
    said = capsys.readouterr().out
    assert float(re.search(r"motion driven by motors: (\S+) s", said)[1]) > 9.9
    assert "their efforts are known torques" in said
    with pytest.raises(TrialError, match="motors drive the joints"):
        load_trial(tmp_path / "bag", TrialOptions(input="none"))


@NEEDS_DRIVEN
def test_what_the_angles_of_driven_joints_mean_is_checked(tmp_path, capsys):
    assert import_csv([str(DRIVEN / "run3.csv.gz"), "--out", str(tmp_path / "bag")]) == 2
    assert "set --zero hanging" in capsys.readouterr().err
