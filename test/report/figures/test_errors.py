"""The errors before and after, of the search, and along the selection of effects."""

import numpy as np
import pytest

from cdp_ident.report.figures.description import Bars, Level
from cdp_ident.report.figures.errors import before_and_after, best_error, selection


def test_errors_stand_beside_the_noise(read_content):
    figure = before_and_after(read_content)
    before, after, noise = figure.panels[0].marks
    errors = read_content["before"]["error"]
    assert before.lengths == pytest.approx(
        [1e3 * errors[role]["rmse_rad"] for role in ("holdout", "validation", "fit")]
    )
    assert max(after.lengths) < min(before.lengths) / 10
    assert isinstance(noise, Level)
    assert noise.value == pytest.approx(0.278, rel=0.03)
    assert f"{before.lengths[0]:.3g} mrad held out" in figure.alternative


def test_the_search_s_history_is_shown_on_a_logarithmic_axis_where_it_falls_far(read_content):
    read_content["search"]["history"] = [100.0, 5.0, 0.1]
    figure = best_error(read_content)
    assert figure.panels[0].y.logarithmic
    assert np.array_equal(figure.panels[0].marks[0].y, [100.0, 5.0, 0.1])
    read_content["search"]["history"] = [10.0, 9.0]
    assert not best_error(read_content).panels[0].y.logarithmic


@pytest.fixture
def with_many_tried(read_content):
    """The report, as if what was tried later had been tried at the first step, and that had been the only one."""
    first = read_content["selection"]["steps"][0]
    keys = ("air_drag.outer.strips", "load_friction.outer", "quadratic_friction.outer", "encoder_offset.outer")
    others = [first["tried"][0] | {"effects": [key]} for key in keys]
    first["tried"] = [others[0], *first["tried"], *others[1:]]
    read_content["selection"]["steps"] = [first]
    return read_content


def test_every_effect_that_was_tried_is_in_the_picture_and_the_added_one_stands_out(with_many_tried):
    read_content = with_many_tried
    (figure,) = selection(read_content)
    panel = figure.panels[0]
    tried = read_content["selection"]["steps"][0]["tried"]
    assert [name.replace("\n", " ") for _, name in panel.y.ticks][:1] == [
        tried[0]["effects"][0].replace("_", " ").replace(".", ", ")
    ]
    bars = {mark.label: mark for mark in panel.marks if isinstance(mark, Bars)}
    assert len(bars["added"].lengths) == 1
    assert len(bars["tried, not added"].lengths) == len(tried) - 1
    place = [position for position, _ in panel.y.ticks].index(bars["added"].positions[0])
    assert tried[place]["effects"] == ["coulomb_friction.outer"]
    assert panel.title == "Step 1: added coulomb friction, outer"
    level = next(mark for mark in panel.marks if isinstance(mark, Level))
    assert level.value == pytest.approx(1e3 * read_content["before"]["error"]["validation"]["rmse_rad"])


def test_a_pair_that_was_added_together_stands_out(with_many_tried):
    read_content = with_many_tried
    pair = read_content["selection"]["steps"][0]["tried"][3] | {"effects": ["air_drag.inner", "joint_spring.outer"]}
    step = {"action": "added air_drag.inner and joint_spring.outer", "rmse_fit_rad": 1e-3, "rmse_validation_rad": 1e-3}
    read_content["selection"]["steps"].append(step | {"tried": [pair]})
    (figure,) = selection(read_content)
    assert [mark.label for mark in figure.panels[1].marks] == ["added", "without it"]


def test_a_name_of_many_lines_has_room_of_its_own(with_many_tried):
    read_content = with_many_tried
    tried = read_content["selection"]["steps"][0]["tried"]
    tried[1]["effects"] = ["encoder_eccentricity.outer", "encoder_eccentricity.inner", "gravity_tilt.base"]
    (figure,) = selection(read_content)
    positions = [position for position, _ in figure.panels[0].y.ticks]
    lines = figure.panels[0].y.ticks[1][1].count("\n") + 1
    assert lines > 2
    assert positions[2] - positions[1] > positions[4] - positions[3]
    assert figure.panels[0].height / (positions[-1] - positions[0] + 1) * (positions[2] - positions[0]) > 13 * (
        lines + 1
    )


def test_what_its_fit_ruled_out_has_no_bar(with_many_tried):
    read_content = with_many_tried
    tried = read_content["selection"]["steps"][0]["tried"]
    tried[-1]["rmse_validation_rad"], tried[-2]["rmse_validation_rad"] = None, float("nan")
    (figure,) = selection(read_content)
    assert len(figure.panels[0].y.ticks) == len(tried) - 2
    for one in tried:
        one["rmse_validation_rad"] = None
    assert list(selection(read_content)) == []


def test_where_nothing_was_tried_there_is_no_picture_of_it(read_content):
    for step in read_content["selection"]["steps"]:
        step["tried"] = []
    assert list(selection(read_content)) == []
