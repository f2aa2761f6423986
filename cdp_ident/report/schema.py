"""The schema of `report.json`: the one statement of what it holds, for writing, reading and documentation.

It is a JSON Schema (draft 2020-12). `null` stands for a number that is not finite, and is read as infinite.
Everything that is repeated has a size, since a report may come from anyone.
"""

import re
from collections.abc import Callable
from typing import Any, get_args

from jsonschema import Draft202012Validator

from cdp_ident.configuration.keys import KEYS, WEIGHTS
from cdp_ident.diagnosis.prediction import POINTS as AHEAD
from cdp_ident.model.effects.effect import JOINTS, Joint
from cdp_ident.model.parameters import CONSTANTS, GROUPS, NOMINAL, SYMBOLS
from cdp_ident.model.weights import RODS
from cdp_ident.outside_text import shown
from cdp_ident.report.schema_terms import (
    Schema,
    a_list,
    a_map,
    an_object,
    count,
    finite,
    flag,
    number,
    object_or_null,
    objects,
    one_of,
    or_null,
    points,
    text,
)
from cdp_ident.tracing.found_effects import POINTS
from cdp_ident.tracing.selection import Certainty

Section = dict[str, Any]
"""A report, or a part of one."""

SCHEMA = "cdp_ident/report/1"
MOST_STARTS = 361
"""Angles of a map of starts, either way."""
_MOST_GENERATIONS = _MOST_OUTLIERS = 1_000_000


_OF_JOINTS = {str(joint): number() for joint in JOINTS}
_SIZES = {str(joint): finite() for joint in JOINTS}
_TIME_NOISE = finite("standard deviation of errors in the times of readings, for both encoders alike [s]; 0 for none")
_BASE_MOVES = flag("whether the inner one is no torque in the joint, but an acceleration of the base, times a1")
_GROUPS = tuple(group.symbol for group in GROUPS)
_ESTIMATE = an_object("a number and its standard deviation", value=number(), std=number())
_QUANTITY = an_object(
    "a fitted number",
    value=number("in the unit that stands beside it"),
    std=number("its standard deviation"),
    unit=text("in SI"),
    determined=flag("whether trials and measured values determine it"),
)
_ERROR = an_object(
    "measured less simulated angles",
    rmse_rad=number("root mean square of both angles, over windows whose initial states are fitted [rad]"),
    rmse_theta1_rad=number("of the inner rod alone [rad]"),
    rmse_theta2_rad=number("of the outer rod alone [rad]"),
    window_s=finite("mean duration of the windows [s]"),
    sse_free_run=number("Eq. (10): sum of squares, each trial simulated as a whole from its beginning [rad^2]"),
    fit_theta1_percent=number("NRMSE fit of the inner rod over all windows together, 100 where nothing is left [%]"),
    fit_theta2_percent=number("of the outer rod [%]"),
)
_ERRORS = an_object("over fitted motion, and over what neither fit nor choice has seen", fit=_ERROR, holdout=_ERROR)
_WEIGHT = an_object(
    rod=one_of(RODS),
    mass=finite("[kg]"),
    place=finite("distance of its centre from the rod's own joint [m]"),
    inertia=finite("about its own centre [kg m^2]"),
    mass_std=finite("standard deviation of the mass [kg]"),
    place_std=finite("of the place [m]"),
)
_CHANGES = a_map(number(), "by which power of a common factor each of them changes")


def _fit(about: str) -> Schema:
    return an_object(
        about,
        physical=an_object("physical values, in SI units", **dict.fromkeys((*SYMBOLS, "L", "g", "A22"), _QUANTITY)),
        physical_possible=flag("whether any mechanism has these base parameters"),
        outer_rod_length_m=finite("what the outer rod's length was taken to be, for air drag [m]"),
        groups=an_object("all that a free swing depends on", **dict.fromkeys(_GROUPS, _QUANTITY)),
        weight_errors=objects(
            "estimated errors of the weights clamped to the rods",
            "by how much a weight differs from its given value, in given standard deviations",
            of=one_of(("mass", "place")),
            rod=or_null(one_of(RODS, "on which it is there; null for a mass, wherever it is")),
            given=finite("the mass [kg] or place [m]"),
            value=finite(),
            std=number(),
        ),
        correlation=an_object(
            "how the errors of the estimates go together",
            names=a_list(text(), "of the estimates"),
            matrix=a_list(a_list(number()), "from -1 to 1"),
        ),
        error=_ERRORS,
    )


_CURVE = an_object(
    "the shape of a nonparametric torque",
    over=one_of(("angle", "speed"), "of its joint, on which it depends"),
    at=points(finite(), "angles from hanging [rad] or speeds [rad/s]", POINTS),
    torque=points(number(), "there; of dry friction its size [N m]", POINTS),
    std=points(number(), "its standard deviation, that of A22 apart [N m]", POINTS),
    coefficients=a_list(finite(), "of the spline [N m]"),
    coefficients_std=a_list(number(), "their standard deviations [N m]"),
    likeness=text("what has such a torque; empty where it is like nothing known"),
)
_NAMES = {"pattern": "^[a-z][a-z0-9_]{0,60}$"}
_NAME = text("in the catalogue, or of the user's own effects") | _NAMES
_EFFECT = an_object(
    "an effect that was added to the model",
    name=_NAME,
    joint=one_of(get_args(Joint)),
    variant=text("which form of it"),
    trial=or_null(text("the trial that it happened in, of an effect that happens once")),
    description=text(),
    summary=text("the effect with its place and strength, and what else it may be"),
    formula=text(),
    source=text(),
    parameters=a_map(
        an_object(
            value=number(),
            std=number("its standard deviation"),
            unit=text("in SI"),
            as_fitted=_ESTIMATE | {"description": "the torque over A22, which is what motion shows"},
        ),
        "by name",
        _NAMES,
    ),
    evidence=an_object(
        "what it brings",
        log10_odds=number(
            "of the model with all effects against the same without it; null where that cannot be fitted"
        ),
        probability=finite("that it is there, among all models that were fitted"),
        rmse_holdout_before_rad=number("error over what was held out, without it [rad]"),
        rmse_holdout_after_rad=number("with it [rad]"),
    ),
    curve=or_null(_CURVE),
    certainty=one_of(get_args(Certainty), "how sure its name is"),
    also_possible=a_list(text("its key"), "what could stand in its place"),
)
_PREDICTION = an_object(
    "error of the prediction, the larger one of both angles'",
    median_rad=points(number(), "that half of the starts exceed [rad]", AHEAD),
    upper_rad=points(number(), "that a quarter of the starts exceeds [rad]", AHEAD),
    within=objects(
        "for how long the model predicts",
        limit_deg=finite("error up to which [degrees]"),
        median_s=finite("half of the starts are predicted so long, or longer [s]"),
        longer=flag("whether these are within it up to the horizon"),
    ),
)
_CORRELATIONS = an_object(
    "correlation by lag",
    values=a_list(number(), "from -1 to 1, lag by lag"),
    bound=number("within which all lags together are in 99 % of cases where there is no relation"),
    related=flag("whether one is beyond it"),
)
_WHITENESS = an_object(
    "of measured less simulated angles over what was held out",
    white=flag("whether neither angle's residuals are correlated in time"),
    theta1=_CORRELATIONS | {"description": "with itself, from lag 0 on"},
    theta2=_CORRELATIONS | {"description": "with itself, from lag 0 on"},
    crosswise=_CORRELATIONS | {"description": "of theta1 with theta2 later; lag 0, in the middle, does not count"},
    cart=object_or_null(
        "of the cart's acceleration with the angles later, lag 0 in the middle; null where it is at rest",
        theta1=_CORRELATIONS,
        theta2=_CORRELATIONS,
    ),
)
_ANGLES = a_list(finite(), "from hanging, positive towards +x [rad]", MOST_STARTS)
ADVICE = an_object(
    "the start that tells most of something",
    **{"for": text("what it is about: `all` base parameters, `A22`, another unknown, or an effect by its label")},
    against=or_null(text("key of the effect that it tells that one from")),
    weights=a_list(_WEIGHT, "what to clamp to the rods"),
    inner_rad=finite("where to hold the inner rod, from hanging, positive towards +x [rad]"),
    outer_rad=finite("where to hold the outer rod, from hanging, positive towards +x [rad]"),
    expected=number(
        "share of their width to which intervals fall (geometric mean), or, where one value is not determined yet, its "
        "relative standard deviation then; of two effects, standard deviations between them; the median over what a "
        "hand may miss the start by"
    ),
    worst=number("the worst of the same"),
    expected_unloaded=number("the same of the start that is best without a weight; null where that is the advice"),
    names=a_list(text(), "the unknowns that it tells of"),
    std_now=a_list(number(), "their standard deviations"),
    std_then=a_list(number(), "the same after a trial that begins exactly there"),
    deviations_now=number("standard deviations between the two effects in the trials that there are"),
    map=an_object(
        "the same as `expected` for each start, were it met exactly",
        inner_rad=_ANGLES,
        outer_rad=_ANGLES,
        values=a_list(a_list(number(), "by the outer rod's", MOST_STARTS), "by the inner rod's angle", MOST_STARTS),
    ),
)


def _number_or_none(about: str) -> Schema:
    return or_null(finite(about))


_KINDS: dict[type, Callable[[str], Schema]] = {bool: flag, int: count, float: _number_or_none, str: text}
_REQUIRED_OPTIONS = (*(constant.symbol for constant in CONSTANTS), *(f"nominal.{symbol}" for symbol in SYMBOLS))
assert {*SYMBOLS, "L", "g"} == set(NOMINAL)

REPORT: Schema = {
    "$schema": "https://json-schema.org/draft/2020-12/schema",
    **an_object(
        "the report of an identification",
        schema=one_of((SCHEMA,), "of this file"),
        trials=objects(
            "each bag",
            bag=text("where it was"),
            name=text(),
            role=one_of(("fit", "holdout")),
            samples=count(),
            start_s=finite("where the free swing begins in the bag [s]"),
            duration_s=finite("of the free swing [s]"),
            clock=object_or_null(
                "the device's clock, where the trial has its time",
                fast=finite("by how much it runs fast against ROS time, relative"),
                std=finite("standard deviation of that"),
            ),
            outliers_s=a_list(finite(), "when samples were left out as outliers, in the bag [s]", _MOST_OUTLIERS),
            weights=a_list(_WEIGHT, "known weights that were clamped to the rods"),
            warnings=a_list(text(), "what was cut or noticed"),
        ),
        noise_rad=an_object("of the encoders, estimated from the data", theta1=finite("[rad]"), theta2=finite("[rad]")),
        search=an_object(
            "settings and course of the genetic search",
            method=text(),
            cut_short=flag("whether it was cut short, since a refinement follows"),
            seed=count("of all chance"),
            population=count(),
            generations=count("of the last search"),
            evaluations=count("chromosomes simulated"),
            best=an_object("its best chromosome, in SI units", **dict.fromkeys(SYMBOLS, finite())),
            sse=number("the error of that [rad^2]"),
            seconds=finite("that it took [s]"),
            history=a_list(number(), "the best error by generation [rad^2]", _MOST_GENERATIONS),
            stopped=text("why it ended"),
        ),
        stages=an_object(
            "the error of the nominal values, of the search's best, and refined",
            nominal=_ERRORS,
            search=_ERRORS,
            refined=_ERRORS,
        ),
        before=_fit("the paper's model as fitted"),
        refinement=an_object(
            "course of the refinement",
            steps=count("of Gauss and Newton"),
            converged=flag(),
            windows=an_object("by role", fit=count(), holdout=count()),
        ),
        effects=a_list(_EFFECT, "each effect that was added", 100),
        after=_fit("the model with the effects"),
        unexplained=an_object(
            "what remains",
            significant=flag("whether it is more than noise"),
            joint=text("in which it is"),
            times_noise=number("error over what was held out, over the noise"),
            torque=an_object("root mean square of the missing torque in each joint [N m]", **_OF_JOINTS),
            description=text("where it is"),
        ),
        verdict=text("the result in one sentence"),
        prediction=object_or_null(
            "how far ahead the models predict from a state fitted to measured angles; null where trials are short",
            held_out=flag("whether in trials that neither fit nor choice has seen"),
            starts=count("from how many instants"),
            told_s=finite("length of the motion before a start to which its state is fitted [s]"),
            horizon_s=finite("how far ahead is predicted [s]"),
            time_s=points(finite(), "since the start [s]", AHEAD),
            before=_PREDICTION,
            after=_PREDICTION,
        ),
        residuals=an_object(
            "what is left in the residuals beside noise",
            interval_s=finite("from one lag to the next [s]"),
            before=_WHITENESS,
            after=_WHITENESS,
        ),
        next_trial=object_or_null(
            "which trial to record next; null where the fit failed",
            assumed=an_object(
                "of the next trial: recorded as those before",
                duration_s=finite("of the free swing [s]"),
                interval_s=finite("between samples [s]"),
                spacing_s=finite("between the nodes of the swing [s]"),
                half_width_s=finite("for which both readings may be repeated without the rods being at rest [s]"),
                step_s=finite("of the integrator [s]"),
                new_noise_rad=an_object("standard deviation of what is new in each reading's noise [rad]", **_SIZES),
                noise_kept=an_object("autoregressive coefficient of the encoders' noise", **_SIZES),
                noise_mixed=an_object("moving-average coefficient of the encoders' noise", **_SIZES),
                time_noise_s=_TIME_NOISE,
                unknown_torque_over_A22=an_object("standard deviation, white noise over A22 [1/s^1.5]", **_SIZES),
                base_moves=_BASE_MOVES,
                step_rad=an_object("of the encoders, 0 where none shows [rad]", **_SIZES),
            ),
            advice=a_list(ADVICE, "for effects that could be others, all base parameters, and each effect's strength"),
        ),
        selection=an_object(
            "how the effects were selected, and what any other one would do",
            interrupted=flag(),
            looked_in_s=finite("motion in which effects were looked for, 0 where in none; all of it is fitted [s]"),
            steps=objects(
                "",
                action=text("what was done"),
                log10_odds=number("of the model after it against the paper's"),
                tried=objects(
                    "the models that were fitted",
                    effects=a_list(text("name, joint and form")),
                    log10_odds=number("of the model with them against the one before"),
                ),
            ),
            candidates=objects(
                "every effect that the final model does not have, the most probable first",
                effect=text("its key"),
                log10_odds=number("of the final model with it against the same without it, by its score"),
                probability=finite("that it is there, beside the final model"),
            ),
        ),
        values_with_less_torque=flag("whether the final values are those with less unknown torque"),
        whole_swings=object_or_null(
            "the likelihood of whole swings, given all that was measured; null where no maximum was found",
            noise_rad=an_object("standard deviation of the encoders' noise [rad]", **_OF_JOINTS),
            noise_memory=an_object("its correlation from one reading to the next", **_OF_JOINTS),
            time_noise_s=_TIME_NOISE,
            missing_torque=an_object(
                "standard deviation of unknown torques in the joints, white noise [N m s^0.5]; 0 where none is missing",
                **_OF_JOINTS,
            ),
            base_moves=_BASE_MOVES,
            swings=count("stretches of the trials without interruption"),
            steps=count("of Gauss and Newton"),
        ),
        repeatability=object_or_null(
            "each trial's own estimate beside the joint one",
            agree=flag("at 1 %"),
            p_value=finite(),
            trials=objects("", trial=text(), groups=an_object("its own estimate", **dict.fromkeys(_GROUPS, _ESTIMATE))),
        ),
        expected=objects(
            "with --like: what became of the effects of the earlier report, and which are new",
            name=_NAME,
            joint=one_of(get_args(Joint)),
            variant=text(),
            state=one_of(("confirmed", "withdrawn", "new"), "in these trials"),
            parameters=a_map(
                an_object(
                    before=number("as fitted, torques over A22"),
                    now=number("the same in these trials"),
                    deviations=number("standard deviations between them"),
                ),
                "of what is confirmed",
            ),
        ),
        new_trials=objects(
            "with --watch: how each trial that came later fitted before it was seen",
            trial=text(),
            rmse_rad=number("[rad]"),
            expected_rmse_rad=number("[rad]"),
            fits=flag(),
            changed=objects(
                "",
                name=text(),
                before=number(),
                alone=number("by a fit of this trial alone"),
                deviations=number("standard deviations between them"),
            ),
        ),
        identifiability=an_object(
            "what the trials determine",
            directions=objects(
                "combinations, by how well they are seen", singular_value=number(), exponents=a_map(number())
            ),
            undetermined=a_list(text()),
            unseen_changes=a_list(_CHANGES, "of base parameters that change together without changing the motion"),
            determined_physical=a_list(text()),
            physical_changes_without_effect=a_list(_CHANGES, "of physical values"),
            to_measure=a_list(text(), "what would determine more"),
            words=a_list(text(), "the same for people"),
        ),
        own_effects=a_map({"type": "object"}, "the user's own effects, defined as in the file of --effects", _NAMES),
        in_doubt=objects(
            "effects that the trials neither show nor exclude, the most likely first; intervals allow for them",
            effect=text("its key, as in the selection"),
            weight=finite("its probability, beside that of the model without it"),
            changes=an_object("by how much it would change base parameters", **dict.fromkeys(_GROUPS, number())),
        ),
        warnings=objects(
            "what is to be doubted", name=text(), about=a_list(text(), "what it is about"), message=text()
        ),
        run=an_object(
            "what is needed to repeat it",
            written_at=text("ISO 8601"),
            seconds=finite("that it took [s]"),
            versions=a_map(text(), "of the software"),
            options=an_object(
                "every setting in effect, as in config/identify.yaml",
                tuple(name for name in KEYS if name not in _REQUIRED_OPTIONS),
                **{name: _KINDS[key.kind](key.description) for name, key in KEYS.items()},
            )
            | {"patternProperties": {f"^{re.escape(WEIGHTS)}": a_list(finite(), "see docs/how_to/weights.md", 3)}},
            bag_sha256=a_map(a_map(text()), "of each bag's files, by their names"),
        ),
    ),
}

_VALIDATOR = Draft202012Validator(REPORT)


def problem(content: Any) -> str:
    """Return what of a report contradicts the schema, and where, in one short line; empty if nothing does."""
    error = next(iter(_VALIDATOR.iter_errors(content)), None)
    if error is None:
        return ""
    place = "".join(f"[{part}]" if isinstance(part, int) else f".{part}" for part in error.absolute_path)
    return f"{shown(place.lstrip('.'), 200) or 'it'}: {shown(error.message, 200)}"
