# Copyright 2026 cdp_ident maintainers
# SPDX-License-Identifier: Apache-2.0
"""A report is drawn from its numbers and curves alone."""

import re

from cdp_ident.report.folder import FIGURES, PAGE, TEXT

PICTURES = {
    "errors", "candidates", "angles_1_swing_wide", "angles_2_swing_folded", "angles_3_swing_check",
    "contrast_1_swing_wide", "contrast_2_swing_folded", "contrast_3_swing_check",
    "selection", "torque_over_time",
    "torque_over_speed", "torque_over_angle", "prediction", "residual_correlation", "next_trial",
    "effect_1_coulomb_friction_outer", "parameters", "correlation", "repeatability",
}  # fmt: skip


def test_every_picture_is_there_as_png_and_svg(report_folder):
    names = {path.name for path in (report_folder / FIGURES).iterdir()}
    assert names == {f"{name}.{kind}" for name in PICTURES for kind in ("png", "svg")}


def test_the_page_is_one_file_of_less_than_2_mb(report_folder):
    assert (report_folder / PAGE).stat().st_size < 2_000_000


def test_the_text_has_the_verdict_the_numbers_and_links_to_figures_that_are_there(report_folder, read_content):
    text = (report_folder / TEXT).read_text()
    assert read_content["verdict"] in text
    links = re.findall(r"\]\((figures/\S+)\)", text)
    assert len(links) == len(PICTURES)
    assert all((report_folder / link).exists() for link in links)
    assert "dry friction (outer joint) | torque | 0.0336" in text
