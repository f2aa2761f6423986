# Copyright 2026 cdp_ident maintainers
# SPDX-License-Identifier: Apache-2.0
"""The emulated rig's YAML file, and scripts of the hand in it."""

import math
from pathlib import Path

import numpy as np
import pytest
import yaml

from cdp_ident.errors import OptionError
from cdp_ident.model.acting import NO_EFFECTS
from cdp_ident.model.effects.catalogue import forget_own
from cdp_ident.model.motions import accelerations_at
from cdp_ident.model.parameters import NOMINAL, SYMBOLS, inertia_about_cart, physical_coefficients
from cdp_ident.rig.emulator.configuration import EmulatedRig, load_rig, parse_script
from cdp_ident.rig.emulator.motion import Drive, Hold, LetGo, MoveCart, Wait, WaitForCommand
from reference.weights import with_weight

ROOT = Path(__file__).parents[3]
A22 = inertia_about_cart(np.array([NOMINAL[symbol] for symbol in SYMBOLS]), NOMINAL["L"])


@pytest.fixture
def load(tmp_path):
    """Return the rig of a file with this text."""

    def run(text):
        (tmp_path / "rig.yaml").write_text(text)
        return load_rig(tmp_path / "rig.yaml")

    return run


def test_an_empty_mapping_is_the_default_rig(load):
    assert load("{}") == EmulatedRig()


def test_what_is_given_replaces_only_itself(load):
    rig = load(
        "parameters: {c1: 0.01}\nencoders: {inner_counts_per_turn: 4096, noise: -0.0}\n"
        "rate: 500\nrepeat: 2\nscript: [wait: 1]"
    )
    assert rig.parameters == NOMINAL | {"c1": 0.01}
    assert rig.encoders.inner_counts_per_turn == 4096
    assert math.copysign(1.0, rig.encoders.noise) == 1.0
    assert isinstance(rig.encoders.inner_counts_per_turn, int)
    assert rig.encoders.outer_counts_per_turn == 8000
    assert (rig.rate, len(rig.script)) == (500.0, 2)


def test_effects_are_chosen_from_the_catalogue_in_physical_units(load):
    effects = load("""
effects:
  coulomb_friction: {inner: {torque: 0.002}}
  cogging_torque: {outer: {sine: 0.001, cosine: 0, periods: 7}}
  encoder_scale: {outer: {scale: 0.01}}
""").effects
    assert {effect.key: values for effect, values in effects.each()} == {
        "coulomb_friction.inner": pytest.approx([0.002 / A22]),
        "cogging_torque.outer.7 per turn": pytest.approx([0.001 / A22, 0.0, 7.0]),
        "encoder_scale.outer": [0.01],
    }


def test_an_effect_of_one_s_own_moves_the_rig(load):
    try:
        effects = load("""
own_effects:
  hardening: {joint: inner, torque: "-k*angle^3", parameters: {k: {unit: N m, limits: [0, 1], typical: 0.01}}}
effects:
  hardening: {inner: {k: 0.02}}
""").effects
        hanging = np.pi + 0.5
        with_it, without = (
            accelerations_at(physical_coefficients(NOMINAL), np.array([[hanging, hanging, 0, 0]]), np.zeros(1), acting)
            for acting in (effects, NO_EFFECTS)
        )
    finally:
        forget_own()
    A23, A33 = physical_coefficients(NOMINAL)[:2]
    # The rods are in line, so that the cosine between them is one.
    expected = np.linalg.solve([[1.0, A23], [A23, A33]], [-0.02 / A22 * 0.5**3, 0.0])
    assert with_it[0] - without[0] == pytest.approx(expected, rel=1e-9)


def test_an_effect_s_optional_parameter_may_be_left_out(load):
    drag = "effects: {air_drag: {outer: {variant: strips, coefficient: 0.002"
    without, same, other = (
        load(f"{drag}{more}}}}}}}").effects.values for more in ("", ", length_ratio: 1", ", length_ratio: 2")
    )
    assert same.tolist() == without.tolist()
    assert other.tolist() != without.tolist()


@pytest.mark.parametrize("rod", ["inner", "outer"])
def test_a_rig_with_a_weight_has_the_physics_of_heavier_rods(load, rod):
    friction = "effects: {coulomb_friction: {outer: {torque: 0.002}}}"
    rig = load(f"added: {{{rod}: [0.05, 0.3, 2.0e-5]}}\n{friction}")
    expected = with_weight(NOMINAL, rod, 0.05, 0.3, 2e-5)
    assert rig.parameters == NOMINAL
    assert rig.coefficients() == pytest.approx(physical_coefficients(expected))
    heavier = inertia_about_cart(np.array([expected[symbol] for symbol in SYMBOLS]), NOMINAL["L"])
    assert rig.effects.values[0] == pytest.approx(0.002 / heavier)


def test_air_drags_at_the_rod_and_not_at_its_weight(load):
    drag = "effects: {air_drag: {outer: {variant: strips, coefficient: 0.002}}}"
    assert load(f"added: {{outer: [0.5, 0.4]}}\n{drag}").effects.outer_length == NOMINAL["L"]


def test_the_example_file_is_a_rig_and_names_the_default_drive(load):
    example = (ROOT / "config" / "emulated_rig.yaml").read_text(encoding="utf-8")
    assert load(example).rate == 200.0
    assert load(example.replace("# drive:", "drive:")).drive == Drive()


@pytest.mark.parametrize(
    ("text", "words"),
    [
        ("parameter: {}", "did you mean 'parameters'?"),
        ("parameters: {M1: 1.0}", "did you mean 'm1'?"),
        ("parameters: {m1: heavy}", "parameters: m1 is 'heavy'"),
        ("parameters: {L: 0}", "parameters: L is 0"),
        ("parameters: {L: 1.0e+308}", "parameters: L is 1e+308"),
        ("parameters: {m2: 0, J2: 0}", "describe no mechanism"),
        ("parameters: 3", "expected keys"),
        ("rate: 0", "1 to 5000"),
        ("rate: 1e9", "rate is"),
        ("effects: {air_darg: {inner: {}}}", "did you mean 'air_drag'?"),
        ("effects: {air_drag: {base: {}}}", "unknown joint"),
        ("effects: {air_drag: {inner: {}}}", "coefficient [N m s^2] is missing"),
        ("effects: {air_drag: {inner: {coefficient: -1}}}", "coefficient is -1"),
        ("effects: {air_drag: {outer: {coefficient: 0, variant: none}}}", "unknown variant"),
        ("effects: {cogging_torque: {inner: {sine: 0, cosine: 0, periods: 2.5}}}", "not in the catalogue"),
        ("effects: {time_offset: {outer: {delay: -0.01}}}", "delay is -0.01"),
        ("encoders: {noise: -1}", "noise is -1"),
        ("encoders: {metres_per_count: 1.0e-300}", "metres_per_count is 1e-300"),
        ("encoders: {inner_counts_per_turn: 0}", "inner_counts_per_turn is 0"),
        ("added: {outer: 0.05}", "added.outer is 0.05"),
        ("added: {outer: [-0.05, 0.3]}", "added.outer is -0.05"),
        ("added: {middle: [0.05, 0.3]}", "unknown key"),
        ("script: 3", "expected a list"),
        ("drive: {lag: 0}", "drive: lag is 0"),
        ("drive: {spede: 1}", "did you mean 'speed'?"),
        ("{drive: {}, script: [cart: {to: 0.1}]}", "has a drive, which alone moves it"),
        ("script: [wait_for_command]", "has no drive"),
        ("- 3", "expected keys"),
        ("{", "cannot be read"),
        ("", "expected keys"),
    ],
)
def test_what_is_no_rig_is_refused_with_its_place(load, text, words):
    with pytest.raises(OptionError, match=r"rig\.yaml|no mechanism") as caught:
        load(text)
    assert words in str(caught.value)


def test_a_script_is_read_in_its_order():
    text = "[wait: 2, hold: {theta1: 1.0, theta2: 2}, wait_for_command, let_go, cart: {to: 0.1, within: 0.5}]"
    commands = (Wait(2.0), Hold(1.0, 2.0), WaitForCommand(), LetGo(), MoveCart(0.1, 0.5))
    assert parse_script(yaml.safe_load(text), "x") == commands


@pytest.mark.parametrize(
    ("text", "words"),
    [
        ("[]", "expected a list"),
        ("3", "expected a list"),
        ("[wiat: 2]", "did you mean 'wait'?"),
        ("[wait]", "entry 1"),
        ("[wait: -1]", "0 to 1e+06"),
        ("[wait: soon]", "expected a number"),
        ("[wait: .nan]", "expected a number"),
        ("[wait: true]", "expected a number"),
        ("[hold: 3]", "expected keys (theta1, theta2, within)"),
        ("[hold: {theta1: 1.0}]", "theta2 is missing"),
        ("[let_go, hold: {theta1: 1.0, theta2: 1, whithin: 1}]", "did you mean 'within'?"),
        ("[hold: {theta1: 1.0, theta2: 1, within: 0}]", "0.01 to 1e+06"),
        ("[cart: {to: 1, within: 1.0e+300}]", "0.01 to 1e+06"),
        ("[let_go: 3]", "takes no value"),
        ("[{wait: 1, cart: {to: 1}}]", "expected one of"),
    ],
)
def test_what_is_no_script_is_refused_with_its_place(text, words):
    content = yaml.safe_load(text)
    with pytest.raises(OptionError, match=r"rig\.yaml") as caught:
        parse_script(content, "rig.yaml: script")
    assert words in str(caught.value)
