"""What `identify` leaves behind when its report cannot be drawn."""

import sys

from cdp_ident.commands.report import main as draw_again
from cdp_ident.nodes.identify import main
from cdp_ident.report.folder import CURVES, FITTED, PAGE, REPORT
from scenarios.clean_bags import write_clean_bags


def test_without_plotly_numbers_and_curves_are_safe_and_are_drawn_later(tmp_path, capsys, monkeypatch):
    write_clean_bags(tmp_path)
    out = tmp_path / "out"
    with monkeypatch.context() as without:
        without.setitem(sys.modules, "plotly.offline", None)
        assert main(["--bag", str(tmp_path / "swing_wide"), "--out", str(out), "--once"]) == 0
    said = capsys.readouterr().out
    assert f"no pictures: {PAGE} needs plotly, which is not installed: pip install plotly" in said
    assert f"ros2 run cdp_ident report {out}" in said
    assert {path.name for path in out.iterdir()} == {REPORT, FITTED, CURVES}
    assert draw_again([str(out)]) == 0
    assert (out / PAGE).exists()
