"""Recordings of the kinds that were once answered wrongly: as much of each is used as there is."""

from pathlib import Path

import pytest
from rich.console import Console

from cdp_ident.commands.import_csv import main as import_csv
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
