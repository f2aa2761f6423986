# Copyright 2026 cdp_ident maintainers
# SPDX-License-Identifier: Apache-2.0
"""What README.md and the pages that it leads to show is so."""

import re
import subprocess
from pathlib import Path

import pytest

from cdp_ident.configuration.parameter_file import read_parameter_file
from cdp_ident.configuration.settings import Settings
from cdp_ident.executables import EXECUTABLES
from cdp_ident.nodes.identify import main

ROOT = Path(__file__).parents[1]
README = (ROOT / "README.md").read_text()
DOCUMENTS = [*ROOT.glob("*.md"), *ROOT.glob("docs/**/*.md"), *ROOT.glob("bags/*.md")]


def block(language, text=README):
    return re.search(rf"```{language}\n(.*?)```", text, re.DOTALL)[1]


def page(name):
    return (ROOT / "docs" / name).read_text()


def test_the_configuration_is_accepted(tmp_path):
    for text in (README, page("how_to/own_bag.md")):
        (tmp_path / "rig.yaml").write_text(block("yaml", text))
        settings = Settings.of(read_parameter_file(tmp_path / "rig.yaml", "identify").taken())
        assert dict(settings.identify.prior.known) == {"m0": 0.208}


def test_every_executable_stands_in_the_table():
    assert set(re.findall(r"(?m)^\| `(\w+)` \|", README)) == set(EXECUTABLES)
    assert set(re.findall(r"(?m)^```\{command-help\} (\w+)$", page("reference/commands.md"))) == set(EXECUTABLES)


def test_bad_input_is_answered_as_printed(capsys, monkeypatch):
    monkeypatch.chdir(ROOT)
    text = page("reference/identify.md")
    examples = re.findall(r"(?m)^\$ ros2 run cdp_ident identify (.*)\n(identify: error: .*)\n", text)
    assert len(examples) == 3
    for arguments, answer in examples:
        assert main(arguments.split()) == 2
        assert capsys.readouterr().err == f"{answer}\n"


@pytest.mark.parametrize("document", DOCUMENTS, ids=lambda path: path.name)
def test_links_lead_somewhere(document):
    for target in re.findall(r"\]\(([^)#:]+)\)", document.read_text()):
        assert (document.parent / target).exists(), target


def test_the_lines_that_install_it_are_those_that_a_workflow_runs_and_let_pip_do_it():
    run = subprocess.run([ROOT / ".ci/install_lines"], check=True, capture_output=True, text=True).stdout
    assert run == block("", README.partition("## Install")[2])
    assert run.index("export PIP_BREAK_SYSTEM_PACKAGES=1") < run.index("rosdep install")
    assert "source /tmp/install_lines" in (ROOT / ".github/workflows/test.yml").read_text()
