"""Recordings of the kinds that were once answered wrongly: as much of each is used as there is."""

import re
from pathlib import Path

import pytest
from rich.console import Console

from cdp_ident.commands.import_csv import main as import_csv
from cdp_ident.errors import TrialError
from cdp_ident.pipeline.identifier import Identifier, Request
from cdp_ident.trial.load import load_trial

CASES = Path(__file__).parents[3] / "shared" / "cases"

pytestmark = pytest.mark.skipif(not CASES.exists(), reason=f"the recordings are not at {CASES}")


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


def test_microseconds_that_roll_over_are_counted_on(tmp_path, capsys):
    file = CASES / "micros_rollover" / "micros_roll.csv"
    options = ["--angle-unit", "counts", "--counts-per-turn", "8000"]
    assert import_csv([str(file), "--out", str(tmp_path / "bag"), *options]) == 0
    assert load_trial(tmp_path / "bag").duration == pytest.approx(11.87, abs=0.02)


@pytest.mark.parametrize(("dump", "said"), [("dump_a", ""), ("dump_b", "m1, groups.A23_over_A22, std.m1: results")])
def test_a_dump_of_identify_s_parameters_is_its_configuration(capsys, dump, said):
    request = Request((), (), None, None, None, CASES / "param_dump" / f"{dump}.yaml", False)
    settings = Identifier(request, Console(), Console()).settings({})
    assert settings.identify.prior.constant("L") == 0.4
    assert capsys.readouterr().out.startswith(said)


@pytest.mark.parametrize(
    ("file", "columns", "words"),
    [
        ("pendule_pi_single", [], "as those of one pendulum do.* packet, time_us, angle"),
        ("pendule_pi_single", ["packet", "angle"], "the inner joint does not turn.* packet, time_us, angle"),
        ("pendule_pi_cart_single", [], "as those of one pendulum do.* pwm, time_us, position, angle"),
        ("pendule_pi_cart_single", ["position", "angle"], "nothing to do with each other"),
        ("pendule_pi_cart_single", ["angle", "position"], "nothing to do with each other"),
        ("pendule_pi_cart_single", ["pwm", "angle"], "the inner joint does not turn"),
        ("dfki_C1_driven", [], "there is none .*motors drive the joints"),
        ("../../data/dfki_driven/run1", [], "there is none .*motors drive the joints"),
        ("../../data/dfki_driven/run2", ["inner_rad", "outer_rad"], "there is none .*motors drive the joints"),
    ],
)
def test_what_is_no_free_double_pendulum_is_refused_in_one_line(tmp_path, capsys, file, columns, words):
    named = [word for pair in zip(["--inner", "--outer"], columns, strict=False) for word in pair]
    options = ["--out", str(tmp_path / "bag"), "--zero", "hanging", *named, *(["--angle-unit", "rad"] if named else [])]
    assert import_csv([str(CASES / "not_a_double_pendulum" / f"{file}.csv.gz"), *options]) == 2
    (line,) = capsys.readouterr().err.splitlines()
    assert re.search(words, line)


@pytest.mark.parametrize(
    ("file", "options", "least"),
    [
        ("dfki_drops/drop1", ["--zero", "hanging"], 4.8),
        ("dfki_drops/drop2", ["--zero", "hanging"], 4.8),
        ("dfki_drops/drop3", ["--zero", "hanging"], 4.8),
        ("multiarm_free_swing/free_swing_8s_56s_1kHz", ["--outer-angle", "absolute"], 47.9),
    ],
)
def test_good_free_swings_are_taken_with_and_without_motors(tmp_path, file, options, least):
    assert import_csv([str(CASES.parent / "data" / f"{file}.csv.gz"), "--out", str(tmp_path / "bag"), *options]) == 0
    assert load_trial(tmp_path / "bag").duration >= least


def test_efforts_in_a_bag_tell_that_its_joints_are_driven(tmp_path):
    file = CASES.parent / "data" / "dfki_driven" / "run3.csv.gz"
    assert import_csv([str(file), "--out", str(tmp_path / "bag"), "--zero", "hanging", "--anyway"]) == 0
    with pytest.raises(TrialError, match="motors drive the joints"):
        load_trial(tmp_path / "bag")


def test_columns_that_have_rows_of_their_own_give_the_whole_swing(tmp_path):
    file = CASES / "csv_half_empty_rows" / "plotjuggler_halfempty.csv"
    named = [word for joint in ("inner", "outer") for word in (f"--{joint}", f"/joint_states/{joint}_joint/position")]
    assert import_csv([str(file), "--out", str(tmp_path / "bag"), *named]) == 0
    trial = load_trial(tmp_path / "bag")
    assert trial.duration == pytest.approx(11.865, abs=0.01)
    bag = load_trial(Path(__file__).parents[2] / "bags" / "swing_wide")
    assert trial.theta[:2000] == pytest.approx(bag.theta[:2000], abs=2e-3)
