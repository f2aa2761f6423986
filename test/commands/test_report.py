# Copyright 2026 cdp_ident maintainers
# SPDX-License-Identifier: Apache-2.0
"""A report is drawn anew from its folder."""

import json
import shutil

import numpy as np
import pytest

from cdp_ident.commands.report import main
from cdp_ident.report.folder import CURVES, FIGURES, PAGE, REPORT, TEXT


@pytest.fixture
def folder(report_folder, tmp_path):
    for name in (REPORT, CURVES):
        shutil.copy(report_folder / name, tmp_path)
    return tmp_path


@pytest.mark.parametrize("options", [(), pytest.param(("--figures",), marks=pytest.mark.campaign)])
def test_drawn_again_of_numbers_and_curves_it_is_the_same_to_the_byte_and_old_figures_go(
    folder, report_folder, capsys, options
):
    (folder / FIGURES).mkdir()
    (folder / FIGURES / "effect_9_cogging_torque_inner.svg").write_text("of an earlier run")
    (folder / TEXT).write_text(f"![Torque]({FIGURES}/effect_9_cogging_torque_inner.svg)")
    (folder / FIGURES / "of_my_thesis.png").write_text("mine")
    assert main([str(folder), *options]) == 0
    assert str(folder / PAGE) in capsys.readouterr().out
    assert {path.name for path in folder.iterdir()} == {REPORT, CURVES, PAGE, TEXT, FIGURES}
    drawn = [p for p in report_folder.rglob("*") if p.is_file()] if options else [report_folder / PAGE]
    for path in drawn:
        assert (folder / path.relative_to(report_folder)).read_bytes() == path.read_bytes(), path.name
    # The text links to figures, and has chapters of nothing else, where there are any.
    assert [words in (folder / TEXT).read_text() for words in (f"]({FIGURES}/", "## Angles")] == 2 * [bool(options)]
    assert not (folder / FIGURES / "effect_9_cogging_torque_inner.svg").exists()
    assert (folder / FIGURES / "of_my_thesis.png").exists()
    assert (len(list((folder / FIGURES).iterdir())) > 1) == bool(options)


@pytest.mark.parametrize("options", [(), pytest.param(("--figures",), marks=pytest.mark.campaign)])
def test_curves_without_a_usable_number_are_drawn_as_far_as_they_go(folder, options):
    """Which numbers are none is in test_curves_npz.py."""
    with np.load(folder / CURVES) as curves:
        arrays = dict(curves)
    for name, array in arrays.items():
        if array.dtype.kind == "f" and not name.endswith(".time"):
            arrays[name] = np.full(array.shape, np.inf)
    np.savez(folder / CURVES, **arrays)
    assert main([str(folder), *options]) == 0


def changed(**values):
    """Return what changes a report in a folder."""

    def change(folder):
        content = json.loads((folder / REPORT).read_text())
        (folder / REPORT).write_text(json.dumps(content | values))

    return change


def without(name):
    return lambda folder: (folder / name).unlink()


def broken(name):
    return lambda folder: (folder / name).write_bytes((folder / name).read_bytes()[:5000])


@pytest.mark.parametrize(
    ("spoil", "words"),
    [
        (shutil.rmtree, "there is no {}/report.json"),
        (without(REPORT), "there is no {}/report.json"),
        (without(CURVES), "there is no {}/curves.npz"),
        (broken(REPORT), "{}/report.json cannot be read"),
        (broken(CURVES), "{}/curves.npz cannot be read"),
        (changed(schema="cdp_ident/report/0"), "'cdp_ident/report/0', not 'cdp_ident/report/1'"),
        (changed(effects=[]), "does not fit its report.json"),
    ],
)
def test_what_is_no_whole_report_is_refused_in_one_line(folder, refused, spoil, words):
    spoil(folder)
    assert words.format(folder) in refused(main, [folder])
    assert not (folder / PAGE).exists()
