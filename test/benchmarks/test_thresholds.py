"""The documented list of thresholds is that of the module."""

from benchmarks.thresholds import FACTORS, PAGE, PARTS, Threshold, described, hidden, table
from cdp_ident.tracing import thresholds

COUNTS = {"FORMS", "PAIRS"}


def rows_of_the_page():
    lines = [line for line in PAGE.read_text(encoding="utf-8").splitlines() if line.startswith("| `")]
    return [[cell.strip() for cell in line.strip("|").split(" | ")] for line in lines]


def test_every_constant_of_the_module_is_described():
    numbers = {name for name, value in vars(thresholds).items() if name.isupper() and isinstance(value, int | float)}
    assert {threshold.name for threshold in described()} == numbers - COUNTS


def test_the_page_lists_every_threshold_as_the_module_has_it():
    listed = [tuple(row[:5]) for row in rows_of_the_page()]
    assert listed == [(f"`{t.name}`", t.unit, f"{t.value:g}", t.decides, t.origin) for t in described()]


def test_as_they_are_all_truths_give_the_same():
    of_each = {row[5 + FACTORS.index(1.0)] for row in rows_of_the_page()}
    assert len(of_each) == 1
    assert len(of_each.pop().split(", ")) == len(PARTS)


def test_what_a_change_changes_stands_out():
    as_is, other = {**dict.fromkeys(PARTS, 1), "said": "a"}, {**dict.fromkeys(PARTS, 2), "said": "b"}
    results = {f"{t.name} {f:g}": as_is for t in described() for f in FACTORS}
    in_words = {**as_is, "said": "b"}
    lines = table([{"job": "none/1", "results": {**results, "NAMED 2": other, "ALIKE 0.5": in_words}}]).splitlines()
    (line,) = (line for line in lines if line.startswith("| `NAMED` "))
    assert line.endswith("| 1, 1, 1, 1 | 1, 1, 1, 1 | **2, 2, 2, 2 (1)** |")
    (line,) = (line for line in lines if line.startswith("| `ALIKE` "))
    assert line.endswith("| **1, 1, 1, 1 (1)** | 1, 1, 1, 1 | 1, 1, 1, 1 |")
    assert sum("**" in line for line in lines) == 2


def test_a_share_is_never_more_than_all_and_a_ratio_not_less_than_one():
    assert Threshold("A", 0.75, "", "share", "").times(2.0) == 1.0
    assert Threshold("A", 1.2, "", "ratio", "").times(0.5) == 1.1
    assert Threshold("A", 8.0, "", "variances", "").times(0.5) == 4.0


def test_the_page_says_what_was_hidden():
    assert hidden(["none/1", "magnet.outer/2/5"]).endswith("nothing, `magnet.outer` (5).")
    assert "Hidden were" in PAGE.read_text(encoding="utf-8")
