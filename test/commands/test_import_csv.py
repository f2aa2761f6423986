# Copyright 2026 cdp_ident maintainers
# SPDX-License-Identifier: Apache-2.0
"""A CSV file becomes a bag in the project's conventions."""

import gzip
import re
from pathlib import Path

import numpy as np
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st
from rosbags.highlevel import AnyReader
from scipy.interpolate import CubicSpline

from cdp_ident.commands.import_csv import main
from cdp_ident.trial.load import load_trial
from scenarios.tables import swing, text_of

SHARED = Path(__file__).parents[3] / "shared/data"
MEASURED = SHARED / "multiarm_free_swing/free_swing_8s_56s_1kHz.csv.gz"
DROPS = SHARED / "dfki_drops"


TIME, THETA = swing()
RELATIVE = np.column_stack([THETA[:, 0], THETA[:, 1] - THETA[:, 0]])
SHUFFLED = np.random.default_rng(6).permutation(len(TIME))


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
        (RELATIVE * [-1, 1], ["--inner-sign", "-1"]),
        (np.mod(THETA, 2 * np.pi), ["--outer-angle", "absolute"]),
        (THETA - 0.2, ["--outer-angle", "absolute", "--lean", str(np.degrees(0.2))]),
        (RELATIVE * [-1, 1] + [0.2, 0], ["--inner-sign", "-1", "--lean", str(np.degrees(0.2))]),
        (np.pi + 4 * (RELATIVE - np.pi) + [0, 3 * np.pi], ["--inner-scale", "4", "--outer-scale", "4"]),
        (RELATIVE * [1, 0.5], ["--outer-scale", "0.5"]),
    ],
)
def test_every_meaning_of_the_angles_ends_in_the_project_s(convert, angles, options):
    positions, _, _ = convert([TIME, angles], *options)
    difference = positions - RELATIVE
    assert np.abs(difference - 2 * np.pi * np.round(difference[0] / (2 * np.pi))).max() < 1e-6


@pytest.mark.parametrize(
    ("columns", "title", "options"),
    [
        ([TIME, np.degrees(RELATIVE)], "t [s],theta1 [deg],theta2 [deg]", []),
        ([TIME, 1000 * RELATIVE], "t [s],theta1 [mrad],theta2 [mrad]", []),
        ([TIME, RELATIVE * 200 / np.pi], "t [s],theta1 [gon],theta2 [gon]", []),
        ([TIME, RELATIVE / (2 * np.pi)], "t,theta1,theta2", []),
        (
            [TIME, RELATIVE - RELATIVE[0]],
            "t,theta1,theta2",
            ["--inner-offset", str(THETA[0, 0]), "--outer-offset", "0.5"],
        ),
        ([TIME, np.degrees(RELATIVE)], "t,theta1,theta2", []),
        ([1000 * TIME, np.degrees(RELATIVE)], "time_ms,theta1_deg,theta2_deg", []),
        ([1e6 * TIME, RELATIVE], "", []),
        ([RELATIVE[:, ::-1], TIME], "q2,q1,t", []),
        ([RELATIVE], "theta1,theta2", ["--rate", "200"]),
        ([RELATIVE], "", ["--rate", "200"]),
        ([7 + np.arange(len(TIME)), RELATIVE], "frame,theta1,theta2", ["--rate", "200"]),
        ([np.arange(len(TIME)), RELATIVE], "", ["--rate", "200", "--time", "0"]),
    ],
)
def test_what_a_file_says_and_what_its_motion_shows_needs_no_option(convert, columns, title, options):
    positions, stamps, _ = convert(columns, *options, title=title)
    assert np.abs(positions - RELATIVE).max() < 1e-6
    assert np.allclose(np.diff(stamps), 5e6, atol=2)


@settings(max_examples=settings().max_examples // 4, suppress_health_check=[HealthCheck.function_scoped_fixture])
@given(
    form=st.sampled_from([(",", "."), (";", ","), ("\t", "."), (" ", ","), ("|", ".")]),
    unit=st.sampled_from(["rad", "deg"]),
    zero=st.sampled_from(["upright", "hanging"]),
    outer_angle=st.sampled_from(["relative", "absolute"]),
    signs=st.tuples(st.sampled_from([1, -1]), st.sampled_from([1, -1])),
    comment=st.sampled_from(["", "# ", "% "]),
)
def test_any_form_with_its_true_meaning_becomes_the_same_trial(
    tmp_path_factory, form, unit, zero, outer_angle, signs, comment
):
    folder = tmp_path_factory.mktemp("form")
    angles = np.column_stack([THETA[:, 0], RELATIVE[:, 1] if outer_angle == "relative" else THETA[:, 1]])
    angles = angles - np.pi * (zero == "hanging") * np.array([1, outer_angle == "absolute"])
    recorded = angles * signs * (180 / np.pi if unit == "deg" else 1)
    title = f"{comment}time,inner [{unit}],outer [{unit}]"
    (folder / "log.csv").write_text(text_of([TIME, recorded], title=title, delimiter=form[0], decimal=form[1]))
    options = ["--zero", zero, "--outer-angle", outer_angle, f"--inner-sign={signs[0]}", f"--outer-sign={signs[1]}"]
    assert main([str(folder / "log.csv"), "--out", str(folder / "bag"), *options]) == 0
    trial = load_trial(folder / "bag")
    assert np.abs(trial.theta - THETA).max() < 1e-6


@pytest.mark.parametrize(
    ("true", "given", "length"),
    [
        (RELATIVE, ["--outer-angle", "absolute"], 0.09),
        (THETA, [], 0.4),
        (THETA, ["--outer-angle", "relative", "--outer-sign", "-1"], 0.09),
        (RELATIVE * [1, -1], [], 0.4),
        (RELATIVE, ["--zero", "hanging"], 0.09),
        (RELATIVE + np.array([0, np.pi]), [], 0.4),
        (RELATIVE + np.array([np.pi, -np.pi]), [], 0.09),
    ],
)
def test_a_wrong_meaning_is_refused_as_the_user_has_typed_it(refuse, true, given, length):
    # The same motion on a smaller rig is faster.
    noisy = true + np.random.default_rng(1).normal(0, 1e-3, true.shape)
    error = refuse([TIME * np.sqrt(length / 0.4), noisy], *given)
    assert "identify would refuse it" in error
    assert "--anyway" in error
    assert "contradict --" in error or "half a turn" in error
    assert "outer_angle" not in error


def test_counts_per_turn_that_are_wrong_are_refused_with_the_option_that_puts_them_right(refuse):
    error = refuse([TIME, RELATIVE * [1, 0.5]], "--angle-unit", "rad")
    factor = re.search(r"the outer joint's readings are (\S+) times the angle: --outer-scale \1 leaves", error)[1]
    assert float(factor) == pytest.approx(0.5, rel=0.02)
    assert "check the counts per turn, or set that; --anyway" in error


PUSH = 0.06 * np.sin(9 * TIME)[:, None] * [1.0, 0.5]


@pytest.mark.parametrize(
    ("angles", "options", "said"),
    [
        (THETA, ["--anyway"], "warning: identify will refuse it: the data contradict --outer-angle relative"),
        (THETA + PUSH, ["--outer-angle", "absolute"], "warning: "),
    ],
    ids=["who insists", "more than two percent unexplained"],
)
def test_what_casts_doubt_on_a_bag_that_is_made_is_a_warning(convert, capsys, angles, options, said):
    convert([TIME, angles], *options)
    assert said in capsys.readouterr().out


def test_a_right_recording_is_told_what_was_taken_for_granted_and_warned_of_nothing(convert, capsys):
    convert([TIME, RELATIVE])
    said = capsys.readouterr().out
    assert "time from column 't' in s" in said
    assert "inner from column 'a' in rad (not stated" in said
    assert "assumed: --zero upright, --outer-angle relative, --inner-sign 1, --outer-sign 1" in said
    assert "it holds with L = 0.4 " in said
    assert "warning" not in said


def test_zeros_anywhere_are_said_with_the_options_that_put_them_right(refuse):
    error = refuse([TIME, RELATIVE - RELATIVE[0]])
    found = re.search(r"zeros are elsewhere: --inner-offset (\S+) and --outer-offset (\S+) leaves", error)
    assert [float(offset) for offset in found.groups()] == pytest.approx(RELATIVE[0], abs=5e-3)


@pytest.mark.parametrize("digits", [1, 2])
def test_times_that_are_rounded_to_the_same_one_for_several_rows_are_made_even(convert, tmp_path, digits):
    convert([np.floor(TIME * 10**digits + 1e-9) / 10**digits, RELATIVE], digits=9)
    trial = load_trial(tmp_path / "bag")
    assert np.diff(trial.time) == pytest.approx(0.005 * np.ones(len(trial.time) - 1), rel=1e-3)


def test_the_cart_is_taken_in_metres(convert):
    cart = 3 * np.sin(TIME)
    positions, _, recording = convert([TIME, RELATIVE, cart], "--cart", "c", "--cart-unit", "mm", "--cart-sign", "-1")
    assert recording.joints == ("inner_joint", "outer_joint", "cart_joint")
    assert np.allclose(positions[:, 2], -1e-3 * cart)


def test_rows_are_chosen_by_time_and_number(convert):
    _, stamps, _ = convert([1000 * TIME, RELATIVE], "--time-unit", "ms", "--from", "0.5", "--to", "3", "--every", "4")
    assert len(stamps) == 126
    assert np.array_equal(np.unique(np.diff(stamps)), [20_000_000])


@pytest.mark.parametrize(("bits", "unit", "per_second"), [(32, "us", 1e6), (16, "ms", 1e3)])
def test_a_counter_of_time_that_rolls_over_is_counted_on(convert, capsys, bits, unit, per_second):
    counts = np.mod(np.round(TIME * per_second) + 2**bits - round(1.5 * per_second), 2**bits)
    _, stamps, _ = convert([counts, RELATIVE], "--time-unit", unit)
    assert np.allclose(stamps - stamps[0], 1e9 * TIME, atol=1e9 / per_second)
    said = capsys.readouterr().out
    assert f"a counter of {bits} bits, counted on where it rolls over" in said
    assert f"{len(TIME)} samples over {TIME[-1]:.3f} s" in said


def test_a_clock_that_was_set_back_parts_a_file_and_its_duration_is_what_has_passed(convert, capsys):
    _, stamps, _ = convert([TIME - 1000.0 * (TIME > 1.0) + 2000.0, RELATIVE])
    assert len(stamps) == len(TIME)
    said = capsys.readouterr().out
    assert f"{len(TIME)} samples over {TIME[-1] - 0.005:.3f} s" in said
    assert "the clock was set back by 999.995 s" in said


@pytest.mark.parametrize(
    ("since", "options", "start"),
    [
        (0, ["--start-stamp", "2024-05-31T12:00:00.25Z"], 1_717_156_800_250_000_000),
        (1_717_156_800, [], 1_717_156_800_000_000_000),
    ],
    ids=["a date is given", "times since 1970"],
)
def test_the_start_is_the_one_that_is_given_or_the_file_s(convert, since, options, start):
    _, stamps, _ = convert([TIME + since, RELATIVE], *options)
    assert np.allclose(stamps - start, TIME * 1e9, atol=1000 if since else 0)


def test_the_bag_says_how_it_was_made_and_others_read_it(convert, tmp_path):
    convert([TIME, THETA], "--outer-angle", "absolute")
    with AnyReader([tmp_path / "bag"]) as reader:
        assert reader.message_count == len(TIME)
        assert "--outer-angle absolute" in reader.readers[0].custom_data["made_by"]
        assert len(reader.readers[0].custom_data["source_sha256"]) == 64


@pytest.mark.parametrize(
    ("options", "message"),
    [
        (["--inner", "arm"], "no column 'arm'"),
        (["--inner", "a", "--outer", "1"], "cannot be both angles"),
        (["--angle-unit", "counts"], "needs --counts-per-turn"),
        (["--counts-per-turn", "8000"], "goes with --angle-unit counts"),
        (["--angle-unit", "counts", "--counts-per-turn", "0"], "0 is not a number from"),
        (["--every", "0"], "0 is not a number from 1 to"),
        (["--rate", "-5"], "-5 is not a number from 1e-09 to 1e+12"),
        (["--from", "100"], "no row with a time --from 100 s"),
        (["--start-stamp", "0"], "another --start-stamp"),
        (["--cart", "3", "--cart-unit", "counts"], "needs --counts-per-metre"),
        (["--time", "b", "--time-unit", "s", "--from", "1e300"], "does not increase"),
        (["--points", "a", "b"], "--points has 2 columns"),
        (["--points"], "the titles do not tell"),
        (["--to", "0.1"], "hold no stretch"),
    ],
)
def test_bad_input_is_one_line_and_exit_code_2(refuse, options, message):
    assert message in refuse([TIME, RELATIVE, TIME], *options)


NEVER_BOTH = np.column_stack([RELATIVE[:, 0], np.full(len(TIME), np.nan)])
COUNTS = RELATIVE / (2 * np.pi)


@pytest.mark.parametrize(
    ("columns", "title", "message"),
    [
        ([RELATIVE], "theta1,theta2", "has no times: give --rate"),
        ([np.arange(len(TIME)), RELATIVE], "frame,theta1,theta2", "has no times: give --rate"),
        ([np.arange(len(TIME)), RELATIVE], "", "column 0 counts 1, 2, 3: give --rate"),
        ([RELATIVE, TIME], "", "does not increase as times do"),
        ([TIME, RELATIVE], "t,theta1 [counts],theta2 [counts]", "--counts-per-turn"),
        ([TIME, THETA[:, [0, 0]]], "t,theta1_m,theta1_s", "as those of one pendulum do"),
        ([TIME / 60, RELATIVE], "time,inner,outer", "joints 0.00011 m apart: check --time-unit"),
        ([TIME, np.round(COUNTS * 360 * 0.7)], "t,enc1,enc2", "column 'enc1' has whole numbers without a unit"),
        ([TIME, np.round(COUNTS * 400)], "t,a,b", "give --angle-unit counts"),
        ([TIME, np.round(COUNTS * 6000)], "t,enc1,enc2", "--counts-per-turn, or their unit"),
        ([TIME, RELATIVE[:, 0], np.round(COUNTS[:, 1] * 600)], "t,a,b", "column 'b' has whole numbers"),
        ([TIME, np.round(COUNTS * 4096)], "t,a,b", "--angle-unit counts and --counts-per-turn"),
        ([TIME, NEVER_BOTH], "t,inner,outer", f"both inner and outer: {len(TIME)} of {len(TIME)} lack one"),
        ([TIME, RELATIVE[:, ::-1]], "t,a,b", "exchanged: --inner b and --outer a leaves"),
    ],
)
def test_what_the_file_does_not_tell_or_not_rightly_is_asked_for(refuse, columns, title, message):
    assert message in refuse(columns, title=title)


@pytest.mark.parametrize("said", [[], ["--outer-angle", "absolute"]])
def test_one_angle_measured_and_simulated_is_refused_with_the_columns_that_there_are(refuse, said):
    angles = THETA[:, [0, 0]] + np.random.default_rng(1).normal(0, 5e-3, THETA.shape)
    named = ["--inner", "theta1_m", "--outer", "theta1_s", "--angle-unit", "rad", *said]
    error = refuse([TIME, angles], *named, title="t,theta1_m,theta1_s")
    assert "one angle twice, measured and simulated" in error
    assert "columns: t, theta1_m, theta1_s" in error


@pytest.mark.parametrize(
    ("titles", "factor", "warned"),
    [("tau1,tau2", 1.0, False), ("tau1 [mNm],tau2 [mNm]", 1e-3, False), ("current1 [A],current2 [A]", 1.0, True)],
)
def test_torques_are_in_newton_metres_or_there_is_a_warning(convert, capsys, titles, factor, warned):
    torques = np.random.default_rng(1).normal(0, 1e-6, RELATIVE.shape)
    _, _, recording = convert([TIME, RELATIVE, torques], title=f"t,theta1,theta2,{titles}")
    assert recording.efforts == pytest.approx(factor * torques, abs=factor * 1e-8)
    assert ("no torques in N m" in capsys.readouterr().out) == warned


def test_rows_without_a_time_are_counted(run, capsys):
    rows = np.column_stack([TIME, RELATIVE])
    text = "\n".join(",".join(map(str, row[k % 100 == 50 :])) for k, row in enumerate(rows))
    text = "\n".join("," * (line.count(",") == 1) + line for line in text.splitlines())
    assert run("t,inner,outer\n" + text) == 0
    assert f"rows without a time are left out: {len(range(50, len(rows), 100))}" in capsys.readouterr().out


@pytest.mark.parametrize("titles", ["Datum;Uhrzeit;innen;aussen", "Day;At;a;b"])
def test_a_date_in_a_column_of_its_own_stands_before_the_time_of_day(convert, titles):
    clock = [f"23:5{9 - (t < 3)}:{(t - 3) % 60:06.3f}" for t in TIME]
    numbers = (f"{at};{a:.6f};{b:.6f}".replace(".", ",") for at, (a, b) in zip(clock, RELATIVE, strict=True))
    _, stamps, _ = convert("\n".join([titles, *(f"03.05.2024;{row}" for row in numbers)]))
    assert stamps - stamps[0] == pytest.approx(np.round((TIME - TIME[0]) * 1e9), abs=1e6)


def test_an_existing_bag_is_not_overwritten(convert, run, capsys):
    convert([TIME, RELATIVE])
    assert run([TIME, RELATIVE]) == 2
    assert "not overwritten" in capsys.readouterr().err


@pytest.mark.skipif(not MEASURED.exists(), reason="the measured swing is not beside the repository")
def test_a_measured_swing_becomes_a_bag_and_wrong_conventions_are_refused(tmp_path, capsys):
    columns = [str(MEASURED), "--every", "5"]
    assert main([*columns, "--out", str(tmp_path / "right"), "--outer-angle", "absolute", "--length", "0.17272"]) == 0
    assert "warning" not in capsys.readouterr().out
    assert load_trial(tmp_path / "right").duration == pytest.approx(47.995)
    assert main([*columns, "--out", str(tmp_path / "wrong")]) == 2
    assert "--outer-angle absolute leaves" in capsys.readouterr().err


HAS_DROPS = pytest.mark.skipif(not DROPS.exists(), reason="the recordings of the drops are not beside the repository")


@HAS_DROPS
@pytest.mark.parametrize("number", [2, *(pytest.param(other, marks=pytest.mark.campaign) for other in (1, 3))])
def test_a_drop_with_geared_drives_becomes_a_trial(tmp_path, capsys, number):
    file = str(DROPS / f"drop{number}.csv.gz")
    assert main([file, "--out", str(tmp_path / "bag"), "--zero", "hanging", "--length", "0.3"]) == 0
    assert "apart, but the motion" not in capsys.readouterr().out
    trial = load_trial(tmp_path / "bag")
    with gzip.open(file, "rt") as stream:
        end = np.loadtxt(stream, delimiter=",", skiprows=1)[-1, 0]
    assert trial.outliers == ()
    assert 5.0 <= trial.start <= 5.25
    assert trial.start + trial.duration == pytest.approx(end, abs=0.02)


@HAS_DROPS
@pytest.mark.parametrize("wrong", ["--outer-angle absolute --zero hanging", "", "--outer-sign -1 --zero hanging"])
def test_a_drop_is_refused_with_a_wrong_meaning(tmp_path, wrong):
    assert main([str(DROPS / "drop2.csv.gz"), "--out", str(tmp_path / "bag"), *wrong.split()]) == 2


def test_columns_with_rows_of_their_own_are_joined_at_the_times_of_one(convert, capsys):
    lines = ["time,inner,outer"]
    later = RELATIVE[:, 1] + 1e-4 * np.gradient(RELATIVE[:, 1], TIME)
    for seconds, inner, outer in zip(TIME, RELATIVE[:, 0], later, strict=True):
        lines += [f"{seconds:.6f},{inner:.9f},", f"{seconds + 1e-4:.6f},,{outer:.9f}"]
    positions, _, _ = convert("\n".join(lines))
    assert "joints are measured at times of their own" in capsys.readouterr().out
    assert positions == pytest.approx(RELATIVE, abs=2e-4)


@pytest.mark.parametrize(
    ("time", "angles", "options", "said"),
    [
        (TIME, np.repeat(RELATIVE[::4], 4, axis=0), [], "repeat 4 times in motion: 600 repetitions are left out"),
        (
            TIME,
            np.round(RELATIVE / (2 * np.pi) * 4000) % 1024,
            ["--angle-unit", "counts", "--counts-per-turn", "4000"],
            "wrap after 1024 counts (10 bits)",
        ),
        (TIME, np.degrees(RELATIVE) % 360, [], "wrap after 360"),
        (TIME, RELATIVE * [1, 180 / np.pi], [], "outer from column 'b' in deg (not stated"),
        (TIME[::-1], RELATIVE[::-1], [], "stored late are put where their stamps belong"),
        (TIME[SHUFFLED], RELATIVE[SHUFFLED], [], "stored late are put where their stamps belong"),
        (
            TIME,
            np.where(np.isin(np.arange(len(TIME)), [3, 7])[:, None], np.nan, RELATIVE),
            [],
            f"2 of {len(TIME)} samples have no usable number for both rods and are dropped",
        ),
    ],
)
def test_a_file_is_mended_as_a_bag_with_its_numbers_is(convert, capsys, time, angles, options, said):
    positions, stamps, _ = convert([time, angles], *options)
    assert said in capsys.readouterr().out
    places = np.round((stamps - stamps[0]) * 200e-9).astype(int)
    off = positions - RELATIVE[places]
    assert np.abs(off - off[0]).max() < 2e-3


@pytest.mark.parametrize("joined", [False, True])
def test_stamps_in_seconds_and_nanoseconds_are_put_together(convert, joined):
    rows = []
    for seconds, (inner, outer) in zip(TIME, RELATIVE, strict=True):
        whole, rest = divmod(round((seconds + 1_700_000_000.9) * 1e9), 10**9)
        rows.append(f"{whole},{rest},,inner_joint,outer_joint,{inner:.9f},{outer:.9f}")
    head = "header.stamp.sec,header.stamp.nanosec,frame_id,name.0,name.1,position.0,position.1\n" if joined else ""
    positions, stamps, _ = convert(head + "\n".join(rows))
    assert (stamps - stamps[0]) * 1e-9 == pytest.approx(TIME, abs=1e-6)
    assert positions == pytest.approx(RELATIVE, abs=1e-8)


def written(title, *columns):
    """A text with columns of numbers or texts."""
    rows = zip(*(column if isinstance(column, list) else column.tolist() for column in columns), strict=True)
    return f"{title}\n" + "\n".join(",".join(map(str, row)) for row in rows) + "\n"


@pytest.mark.parametrize(
    ("title", "times", "said"),
    [
        ("datenum", 739403.5 + TIME / 86400, "in d (not stated: steps of 5.8e-08 s would be too short for a log)"),
        ("Time [days]", 45443.5 + TIME / 86400, "in d"),
        ("date", [f"05/31/2024 12:00:{time:09.6f}" for time in TIME], "in s"),
        ("datum", [f"31.05.2024 12:00:{time:09.6f}" for time in TIME], "in s"),
        (
            "t",
            [
                f"{int(time // 3600):02d}:{int(time // 60) % 60:02d}:{time % 60:06.3f}"
                for time in (TIME + 86398) % 86400
            ],
            "a time of day, counted on where it rolls over",
        ),
        ("seq,millis", [f"{number % 65536},{1e3 * time}" for number, time in enumerate(TIME)], "'millis' in ms"),
    ],
)
def test_days_dates_and_milliseconds_beside_a_counter_are_times(convert, capsys, title, times, said):
    _, stamps, _ = convert(written(f"{title},inner,outer", times, *RELATIVE.T))
    assert said in capsys.readouterr().out.splitlines()[1]
    assert (stamps - stamps[0]) * 1e-9 == pytest.approx(TIME, abs=2e-5)


LABVIEW = (
    "LabVIEW Measurement\t\nDate\t2024/05/31\n***End_of_Header***\t\n\t\nChannels\t2\t\t\nDelta_X\t0.005\t0.005\t\n"
)
ROWS = [(time, *angles) for time, angles in zip(TIME.tolist(), RELATIVE.tolist(), strict=True)]


@pytest.mark.parametrize(
    ("before", "row", "options"),
    [
        (f"{LABVIEW}X_Value\tinner\touter\tComment", "{0:.4f}\t{1:.7f}\t{2:.7f}\t", []),
        (f"{LABVIEW}X_Value\tinner\touter\tComment", "\t{1:.7f}\t{2:.7f}\t", ["--rate", "200"]),
        ("version,5\nname,t,inner,outer\ntrace_unit,s,rad,rad", "values,{0:.4f},{1:.7f},{2:.7f}", []),
        ("12:00:00.1 -> rst:0x1\n12:00:00.2 -> t,inner,outer", "12:00:0{0:.4f} -> {0:.4f},{1:.7f},{2:.7f}", []),
        ("Booting", "t:{0:.4f},inner:{1:.7f},outer:{2:.7f}", []),
        ("", "t={0:.4f} inner={1:.7f} outer={2:.7f}", []),
        ("", '{{"t": {0:.4f}, "inner": {1:.7f}, "outer": {2:.7f}}}', []),
        ("Time,inner,outer", "{0:.4f} sec,{1:.7f} rad,{2:.7f} rad", []),
        (",inner,outer", "0 days 00:00:0{0:.4f},{1:.7f},{2:.7f}", []),
        ("Time,inner,Time,outer", "{0:.4f},{1:.7f},{0:.4f},{2:.7f}", []),
        ("t [min],inner,outer", "{3:.9f},{1:.7f},{2:.7f}", []),
        ("timestamp,inner,outer", "{4:.4f},{1:.7f},{2:.7f}", []),
        ("t;inner;outer", "{0:.4f};{1:.7f};\u2212{5:.7f}", ["--outer-sign", "1"]),
    ],
)
def test_what_tools_write_is_read_as_it_is(convert, before, row, options):
    lines = (row.format(*of, of[0] / 60.0, of[0] + 3.8e9, -of[2]).replace("\u2212-", "") for of in ROWS)
    positions, stamps, _ = convert("\n".join([before, *lines, ""]), *options)
    assert (stamps - stamps[0]) * 1e-9 == pytest.approx(TIME, abs=1e-5)
    assert positions == pytest.approx(RELATIVE, abs=1e-6)


def test_angles_with_times_of_their_own_are_taken_at_common_times(convert, capsys):
    later = CubicSpline(TIME, RELATIVE[:, 1])(TIME + 0.002)
    positions, stamps, _ = convert(written("Time,inner,Time,outer", TIME, RELATIVE[:, 0], TIME + 0.002, later))
    assert "joints are measured at times of their own" in capsys.readouterr().out
    at = (stamps - stamps[0]) * 1e-9
    assert positions[1:-1] == pytest.approx(CubicSpline(TIME, RELATIVE)(at)[1:-1], abs=1e-4)
