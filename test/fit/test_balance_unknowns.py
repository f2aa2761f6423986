import numpy as np

from cdp_ident.fit.balance_unknowns import DRY, MOMENT, NOT_DRY, Mechanism, Piece, Unknowns
from cdp_ident.model.effects.catalogue import CATALOGUE
from cdp_ident.model.effects.effect import TorqueEffect

EFFECTS = {effect.key: effect for effect in CATALOGUE if isinstance(effect, TorqueEffect)}


def test_unknowns_are_named_as_the_model_names_them():
    effects = tuple(EFFECTS[key] for key in ("geared_rotor.outer", "coulomb_friction.outer", "joint_spring.outer"))
    unknowns = Unknowns(effects, length_free=True)
    assert unknowns.names == (
        "A23_over_A22", "A33_over_A22", "a1_over_A22", "c1_over_A22", "c2_over_A22", MOMENT,
        "geared_rotor.outer.coupling",
        "coulomb_friction.outer.torque", "joint_spring.outer.stiffness", "joint_spring.outer.torque",
    )  # fmt: skip


def test_only_what_may_be_negative_has_no_lower_limit():
    unknowns = Unknowns(
        tuple(EFFECTS[key] for key in ("geared_rotor.outer", "coulomb_friction.inner", "gravity_tilt.base"))
    )
    lower, upper = unknowns.limits
    free = {name for name, limit in zip(unknowns.names, lower, strict=True) if limit < 0}
    assert free == {"geared_rotor.outer.coupling", "gravity_tilt.base.tilt"}
    assert np.all(lower < upper)


def test_an_effect_s_column_is_its_torque_over_its_strength(measured):
    mechanism = Mechanism(0.4, 9.81, 0.4)
    piece = Piece.of(measured(noise=1e-4), mechanism.time_unit)
    effects = (EFFECTS["quadratic_friction.outer"], EFFECTS["joint_spring.inner"])
    rows = mechanism.rows([piece], Unknowns(effects), 0.1, np.zeros(5))
    quadratic, stiffness, torque = np.moveaxis(rows.columns[0][..., 5:], -1, 0)
    assert np.allclose(quadratic[:, 0], 0.0), "a torque of the outer joint is not in the sum of both rods' equations"
    assert np.std(quadratic[:, 1]) > 0.1
    assert np.allclose(torque[:, 0], -1.0)
    assert np.allclose(torque[:, 1], 0.0)
    assert np.std(stiffness[:, 0]) > 0.1


def test_dry_friction_of_any_law_is_its_size_against_the_motion(measured):
    mechanism = Mechanism(0.4, 9.81, 0.4)
    piece = Piece.of(measured(noise=1e-4), mechanism.time_unit)
    effects = (EFFECTS["coulomb_friction.outer"], EFFECTS["load_friction.outer"])
    rows = mechanism.rows([piece], Unknowns(effects), 0.1, np.array([0.5, 0.4, 1.4 / 0.4, 0.1, 0.05]))
    even, load = np.moveaxis(rows.columns[0][..., 5:], -1, 0)
    assert np.allclose(even[:, 0], 0.0)
    assert np.allclose(load[:, 0], 0.0)
    fast = np.abs(even[:, 1]) > 0.999
    assert np.count_nonzero(fast) > 100
    assert np.all(load[fast, 1] * even[fast, 1] > 0.0)
    assert np.std(np.abs(load[fast, 1])) > 0.1


def test_what_is_looked_for_is_what_its_entries_say():
    assert {effect.key for effect in (*DRY, *NOT_DRY)} == {
        effect.key for effect in EFFECTS.values() if effect.in_balance
    }
    assert all(effect.dry for effect in DRY)


def test_an_outer_rod_without_a_moment_shows_no_length(measured):
    mechanism, unknowns = Mechanism(0.4, 9.81, 0.4), Unknowns(length_free=True)
    piece = Piece.of(measured(noise=1e-4), mechanism.time_unit)
    values = np.array([0.0, 0.1, 2.0, 0.1, 0.05, 0.0])
    assert np.isnan(mechanism.length_of(unknowns, values))
    inner, outer = mechanism.gravity_torque(unknowns, values, [piece])
    assert (inner > 1.0, outer) == (True, 0.0)
