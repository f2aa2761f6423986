# Copyright 2026 cdp_ident maintainers
# SPDX-License-Identifier: Apache-2.0
import numpy as np
import pytest

from reference import sticking
from reference.effects import Effect, Occasion, draw
from reference.kinds import GROUPS, KINDS, SINGLE, combined, in_mujoco, spread
from reference.mechanics import Rig
from reference.plant import Plant
from reference.readings import LEAD, Acting, shown
from reference.settings import draw_setting
from reference.sticking import motion
from reference.truths import truth
from reference.visibility import visibility

VALUES = draw_setting(np.random.default_rng(0)).values


def test_a_kind_and_a_seed_always_hide_the_same():
    first, again, another = (truth("encoder_slip.outer", seed) for seed in (3, 3, 4))
    assert all(np.array_equal(a.theta, b.theta) for a, b in zip(first.trials, again.trials, strict=True))
    assert first.hidden[0].strength == again.hidden[0].strength
    assert first.setting.nominal == again.setting.nominal
    assert first.hidden[0].strength != another.hidden[0].strength
    assert first.hidden[0].effect.trial in (0, 1)


def test_both_engines_make_the_same_truth():
    one, other = truth("encoder_offset.outer", 0), truth("encoder_offset.outer", 0, "mujoco")
    assert one.hidden[0].strength == other.hidden[0].strength
    step = 2 * np.pi / one.setting.counter.counts
    for a, b in zip(one.trials, other.trials, strict=True):
        # They agree at first; how long depends on how chaotic the trial is. An angle may be counted the other way.
        quarter = len(a.time) // 4
        assert np.abs(a.theta - b.theta)[:quarter].max() < 2.001 * step


def test_the_floor_is_the_error_of_the_last_trial():
    made = truth("none", 1)
    lengths = [10.0 <= trial.time[-1] + 1.0 / made.setting.rate <= 15.01 for trial in made.trials]
    assert lengths == [True] * 3
    assert made.floor == pytest.approx(made.setting.counter.error * np.sqrt(1.5), rel=0.1)


@pytest.mark.parametrize("joint", ["inner", "outer"])
def test_what_is_to_stop_a_joint_does(joint):
    setting = draw_setting(np.random.default_rng(5))
    stopping = draw(f"stopping.{joint}", Occasion(setting.values, [10.0], np.random.default_rng(0)))
    plant = stopping.in_plant(Plant(Rig(setting.values)), stopping.stopping)
    path = sticking.path(plant, (4.2, 4.2, 0.0, 0.0), np.array([0.0, 15.0]))
    # The inner rod, which swings on, may break the outer joint loose again.
    assert (path.event_modes[:, 0 if joint == "inner" else 1] == 0).any()


@pytest.mark.parametrize("part", sorted({part for kind in KINDS[1:] for part in kind.split("+")}))
def test_every_effect_moves_something_of_what_the_encoders_show(part):
    effect = draw(part, Occasion(VALUES, [2.0], np.random.default_rng(0)))
    plant, times, start = Plant(Rig(VALUES)), np.arange(200) / 100.0, np.array([4.2, 3.9, 0.0, 0.0])
    plain = shown(plant, [], start, times)
    slight, twice, strong = (
        np.abs(shown(plant, [Acting(effect, strength)], start, times) - plain).max()
        for strength in (effect.small, 2.0 * effect.small, effect.largest)
    )
    assert 0.0 < slight < strong
    assert twice == pytest.approx(2.0 * slight, rel=0.05)
    assert (effect.name in part) != (effect.stopping is not None)


def test_no_two_harmonics_of_a_joint_have_as_many_periods_a_turn():
    of = Occasion(VALUES, [2.0], np.random.default_rng(0))
    assert sorted(of.periods("outer") for _ in range(14)) == list(range(3, 17))


def test_an_engine_that_lacks_an_element_says_so():
    assert not in_mujoco("magnet.inner")
    with pytest.raises(ValueError, match="no element"):
        truth("magnet.inner", 0, "mujoco")


def test_a_late_encoder_shows_what_was_there_before():
    late = Effect("time_offset", "outer", "s", 1e-5, 0.02, late=True)
    times, start = np.arange(100) / 100.0, np.array([3.9, 4.4, 0.0, 0.0])
    joints = shown(Plant(Rig(VALUES)), [Acting(late, 0.0123)], start, times)
    there = motion(VALUES, start, np.concatenate([[-LEAD], times]))[1:]
    before = motion(VALUES, start, np.concatenate([[-LEAD], times - 0.0123]))[1:]
    assert joints[:, 0] == pytest.approx(there[:, 0] - np.pi, abs=1e-9)
    assert joints[:, 1] == pytest.approx(before[:, 1] - before[:, 0], abs=1e-9)


def test_what_parameters_imitate_is_not_visible():
    def put(symbol):
        def in_plant(plant, strength):
            values = {**plant.rig.values, symbol: plant.rig.values[symbol] * (1.0 + strength)}
            return Plant(Rig(values))

        return Effect(symbol, "base", "1", 1e-4, 1.0, in_plant)

    start = np.array([3.5, 3.9, 0.0, 0.0])
    imitated, real = (
        visibility(VALUES, [effect], [start], [6.0])[1][0]
        for effect in (put("m1"), Effect("late", "outer", "s", 1e-5, 0.02, late=True))
    )
    assert imitated < 1e-4
    assert real > 1e-2


def test_an_effect_is_visible_by_no_more_than_it_moves_the_middle_window():
    # One window is so chaotic that whatever imitates the drag there moves all others by more than the drag does.
    made = truth("air_drag.outer+time_offset.outer", 95000)
    drag, late = made.hidden
    assert drag.strength == pytest.approx(1.377e-7, rel=1e-3)  # as it was drawn before this was known
    assert drag.visible < 0.2
    assert late.visible > 0.5


def test_what_the_starts_of_windows_do_not_imitate_better_is_as_visible_as_least_squares_leave():
    late, start = Effect("late", "outer", "s", 1e-5, 0.02, late=True), np.array([3.5, 3.9, 0.0, 0.0])
    drawn_by, visible = visibility(VALUES, [late], [start], [6.0])
    assert np.array_equal(drawn_by, visible)


def test_combined_truths_have_up_to_three_different_effects():
    sample = combined(60, ("equations", "mujoco"), first=7)
    assert sample[:20] == combined(20, ("equations", "mujoco"), first=7)
    parts = [kind.split("+") for kind, _, _ in sample]
    assert {2, 3} <= {len(of) for of in parts} <= {1, 2, 3}
    assert all(len(of) == len(set(of)) for of in parts)
    assert not any({"gravity_tilt.base", "side_force.base"} <= set(of) for of in parts)
    assert {part for of in parts for part in of} <= set(SINGLE)
    assert all(engine == "equations" or in_mujoco(kind) for kind, _, engine in sample)
    assert {engine for _, _, engine in sample} == {"equations", "mujoco"}


def test_a_spread_sample_has_all_groups_and_both_engines():
    sample = spread(200, ("equations", "mujoco"), first=7)
    assert len(set(sample)) == 200
    assert sample[:30] == spread(30, ("equations", "mujoco"), first=7)
    drawn = {kind for kind, _, _ in sample[:40]}
    assert all(drawn & set(kinds) for kinds in GROUPS.values())
    assert min(seed for _, seed, _ in sample) == 7
    assert sum(engine == "mujoco" for _, _, engine in sample) > 40
    assert all(in_mujoco(kind) for kind, _, engine in sample if engine == "mujoco")
    assert all(in_mujoco(kind) for kind, _, _ in spread(60, ("mujoco",)))
