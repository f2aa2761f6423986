"""ROS's own linters pass, in the configurations that are here. They come with ROS, or with requirements-dev.txt.

ament_copyright is not among them: QUALITY_DECLARATION.md says why.
"""

import importlib
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[1]
CODE = [str(ROOT / name) for name in ("cdp_ident", "launch", "examples", "setup.py")]
MADE = ["--exclude", str(ROOT / "cdp_ident/model/formulas/laws.py")]


@pytest.mark.parametrize(
    ("linter", "configuration"),
    [
        ("ament_flake8", ["--config", str(ROOT / "setup.cfg")]),
        # Methods say by their names what the magic ones do; a formula is no signature, a file's key no section.
        ("ament_pep257", ["--convention", "google", "--add-ignore", "D105", "D107", "D214", "D402", "D405", "D411"]),
    ],
)
def test_ros_s_linter_finds_nothing(linter, configuration, capfd):
    main = pytest.importorskip(f"{linter}.main", reason=f"{linter} is not installed").main
    assert main([*configuration, *MADE, "--", *CODE]) == 0, capfd.readouterr().out


def test_ros_s_release_tool_reads_the_version_from_the_changes():
    changelog = importlib.import_module("catkin_pkg.changelog").get_changelog_from_path(str(ROOT / "CHANGELOG.rst"))
    package = importlib.import_module("catkin_pkg.package").parse_package(str(ROOT))
    newest, _, changes = next(changelog.foreach_version())
    assert newest == package.version
    assert changes
