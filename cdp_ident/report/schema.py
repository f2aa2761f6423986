"""The schema of `report.json`: the one statement of what it holds, for writing, reading and documentation.

It is a JSON Schema (draft 2020-12). `null` stands for a number that is not finite. Everything that is repeated has a
size, since a report may come from anyone; effects have the catalogue's names.
"""

import re
from collections.abc import Iterator, Mapping
from typing import Any, get_args

from jsonschema import Draft202012Validator

from cdp_ident.configuration.keys import KEYS, WEIGHTS
from cdp_ident.diagnosis.prediction import POINTS as AHEAD
from cdp_ident.model.effects.catalogue import CATALOGUE
from cdp_ident.model.effects.effect import Joint
from cdp_ident.model.parameters import CONSTANTS, GROUPS, NOMINAL, SYMBOLS
from cdp_ident.model.weights import RODS
from cdp_ident.outside_text import shown
from cdp_ident.tracing.found_effects import POINTS
from cdp_ident.tracing.selection import Certainty

Schema = dict[str, Any]

SCHEMA = "cdp_ident/report/1"
LONGEST_TEXT = 4000
"""Letters of any text in a report."""
_LARGEST = 1e300
_MOST = 1000
"""Trials, effects, warnings and the like."""
MOST_STARTS = 361
"""Angles of a map of starts, either way."""
_MOST_GENERATIONS = _MOST_OUTLIERS = 1_000_000


def _object(about: str = "", optional: tuple[str, ...] = (), /, **properties: Schema) -> Schema:
    required = [name for name in properties if name not in optional]
    return {
        "type": "object",
        "description": about,
        "properties": properties,
        "required": required,
        "additionalProperties": False,
    }


def _map(values: Schema, about: str = "", names: Schema | None = None) -> Schema:
    return {
        "type": "object",
        "description": about,
        "additionalProperties": values,
        "propertyNames": names or {"maxLength": LONGEST_TEXT},
        "maxProperties": _MOST,
    }


def _list(items: Schema, about: str = "", most: int = _MOST) -> Schema:
    return {"type": "array", "description": about, "items": items, "maxItems": most}


def _pair(items: Schema, about: str = "") -> Schema:
    return _list(items, about, 2) | {"minItems": 2}


def _points(items: Schema, about: str, count: int = POINTS) -> Schema:
    return _list(items, about, count) | {"minItems": count}


def _finite(about: str = "") -> Schema:
    return {"type": "number", "description": about, "minimum": -_LARGEST, "maximum": _LARGEST}


def _number(about: str = "") -> Schema:
    return {"type": ["number", "null"], "description": about, "minimum": -_LARGEST, "maximum": _LARGEST}


def _count(about: str = "") -> Schema:
    return {"type": "integer", "description": about, "minimum": 0, "maximum": 2**63 - 1}


def _text(about: str = "") -> Schema:
    return {"type": "string", "description": about, "maxLength": LONGEST_TEXT}


def _one_of(words: tuple[str, ...], about: str = "") -> Schema:
    return {"enum": list(dict.fromkeys(words)), "description": about}


def _flag(about: str = "") -> Schema:
    return {"type": "boolean", "description": about}


def _or_null(schema: Schema) -> Schema:
    return {"anyOf": [schema, {"type": "null"}], "description": schema["description"]}


_GROUPS = tuple(group.symbol for group in GROUPS)
_ESTIMATE = _object("a number and its standard deviation", value=_number(), std=_number())
_QUANTITY = _object(
    "a fitted number",
    value=_number("in the unit that stands beside it"),
    std=_number("its standard deviation"),
    unit=_text("in SI"),
    determined=_flag("whether trials and measured values determine it"),
)
_ERROR = _object(
    "measured less simulated angles",
    rmse_rad=_number("root mean square of both angles, over windows whose initial states are fitted [rad]"),
    rmse_theta1_rad=_number("of the inner rod alone [rad]"),
    rmse_theta2_rad=_number("of the outer rod alone [rad]"),
    window_s=_finite("mean duration of the windows [s]"),
    sse_free_run=_number("Eq. (10): sum of squares, each trial simulated as a whole from its beginning [rad^2]"),
    fit_theta1_percent=_number("NRMSE fit of the inner rod over all windows together, 100 where nothing is left [%]"),
    fit_theta2_percent=_number("of the outer rod [%]"),
)
_ERRORS = _object(
    "over fitted motion, over the same predicted fold by fold, and over what neither fit nor choice has seen",
    fit=_ERROR,
    validation=_ERROR,
    holdout=_ERROR,
)
_CHANGES = _map(_number(), "by which power of a common factor each of them changes")


def _fit(about: str) -> Schema:
    return _object(
        about,
        physical=_object("physical values, in SI units", **dict.fromkeys((*SYMBOLS, "L", "g", "A22"), _QUANTITY)),
        physical_possible=_flag("whether any mechanism has these groups"),
        outer_rod_length_m=_finite("what the outer rod's length was taken to be, for air drag [m]"),
        groups=_object("all that a free swing depends on", **dict.fromkeys(_GROUPS, _QUANTITY)),
        correlation=_object(
            "how the errors of the estimates go together",
            names=_list(_text(), "of the estimates"),
            matrix=_list(_list(_number()), "from -1 to 1"),
        ),
        error=_ERRORS,
    )


_CURVE = _object(
    "the shape of a torque without a name",
    over=_one_of(("angle", "speed"), "of its joint, on which it depends"),
    at=_points(_finite(), "angles from hanging [rad] or speeds [rad/s]"),
    torque=_points(_number(), "there; of dry friction its size [N m]"),
    std=_points(_number(), "its standard deviation, that of A22 apart [N m]"),
    coefficients=_list(_finite(), "of the spline [N m]"),
    coefficients_std=_list(_number(), "their standard deviations [N m]"),
    likeness=_text("what has such a torque; empty where it is like nothing known"),
)
_EFFECT = _object(
    "an effect that was added to the model",
    name=_one_of(tuple(effect.name for effect in CATALOGUE), "by the catalogue"),
    joint=_one_of(get_args(Joint)),
    variant=_one_of(("", *(effect.variant for effect in CATALOGUE)), "which form of it"),
    trial=_or_null(_text("the trial that it happened in, of an effect that happens once")),
    description=_text(),
    summary=_text("the effect with its place and strength, and what else it may be"),
    formula=_text(),
    source=_text(),
    parameters=_map(
        _object(
            value=_number(),
            std=_number("its standard deviation"),
            unit=_text("in SI"),
            as_fitted=_ESTIMATE | {"description": "the torque over A22, which is what motion shows"},
        ),
        "by name",
        {"pattern": "^[a-z][a-z0-9_]{0,60}$"},
    ),
    evidence=_object(
        "what it brings",
        rmse_validation_before_rad=_number("error in cross-validation, without it [rad]"),
        rmse_validation_after_rad=_number("with it [rad]"),
        rmse_holdout_before_rad=_number("error over what was held out, without it [rad]"),
        rmse_holdout_after_rad=_number("with it [rad]"),
        delta_bic=_number("change of the Bayesian information criterion"),
    ),
    curve=_or_null(_CURVE),
    certainty=_one_of(get_args(Certainty), "how sure its name is"),
    also_possible=_list(
        _one_of(tuple(f"{effect.name} {effect.joint}" for effect in CATALOGUE)), "what could stand in its place"
    ),
)
_PREDICTION = _object(
    "error of the prediction, the larger one of both angles'",
    median_rad=_points(_number(), "that half of the starts exceed [rad]", AHEAD),
    upper_rad=_points(_number(), "that a quarter of the starts exceeds [rad]", AHEAD),
    within=_list(
        _object(
            limit_deg=_finite("error up to which [degrees]"),
            median_s=_finite("half of the starts are predicted so long, or longer [s]"),
            longer=_flag("whether these are within it up to the horizon"),
        ),
        "for how long the model predicts",
    ),
)
_CORRELATIONS = _object(
    "correlation by lag",
    values=_list(_number(), "from -1 to 1, lag by lag"),
    bound=_number("within which all lags together are in 99 % of cases where there is no relation"),
    related=_flag("whether one is beyond it"),
)
_WHITENESS = _object(
    "of measured less simulated angles over what was held out",
    white=_flag("whether neither angle's residuals are correlated in time"),
    theta1=_CORRELATIONS | {"description": "with itself, from lag 0 on"},
    theta2=_CORRELATIONS | {"description": "with itself, from lag 0 on"},
    crosswise=_CORRELATIONS | {"description": "of theta1 with theta2 later; lag 0, in the middle, does not count"},
    cart=_or_null(
        _object(
            "of the cart's acceleration with the angles later, lag 0 in the middle; null where it is at rest",
            theta1=_CORRELATIONS,
            theta2=_CORRELATIONS,
        )
    ),
)
_ANGLES = _list(_finite(), "from hanging, positive towards +x [rad]", MOST_STARTS)
_ADVICE = _object(
    "the start that tells most of something",
    **{"for": _text("what it tells of: `all` groups, an unknown, or an effect by its label")},
    against=_or_null(_text("name and joint of the effect that it tells that one from")),
    inner_rad=_finite("where to hold the inner rod, from hanging, positive towards +x [rad]"),
    outer_rad=_finite("where to hold the outer rod, from hanging, positive towards +x [rad]"),
    expected=_number(
        "share of their width to which intervals fall (geometric mean); of two effects, standard deviations between "
        "them; the median over what a hand may miss the start by"
    ),
    worst=_number("the worst of the same"),
    names=_list(_text(), "the unknowns that it tells of"),
    std_now=_list(_number(), "their standard deviations"),
    std_then=_list(_number(), "the same after a trial that begins exactly there"),
    deviations_now=_number("standard deviations between the two effects in the trials that there are"),
    map=_object(
        "the same as `expected` for each start, were it met exactly",
        inner_rad=_ANGLES,
        outer_rad=_ANGLES,
        values=_list(_list(_number(), "by the outer rod's", MOST_STARTS), "by the inner rod's angle", MOST_STARTS),
    ),
)
_KINDS = {bool: _flag, int: _count, float: _number, str: _text}
_REQUIRED_OPTIONS = (*(constant.symbol for constant in CONSTANTS), *(f"nominal.{symbol}" for symbol in SYMBOLS))
assert {*SYMBOLS, "L", "g"} == set(NOMINAL)

REPORT: Schema = {
    "$schema": "https://json-schema.org/draft/2020-12/schema",
    **_object(
        "the report of an identification",
        schema=_one_of((SCHEMA,), "of this file"),
        trials=_list(
            _object(
                bag=_text("where it was"),
                name=_text(),
                role=_one_of(("fit", "holdout")),
                samples=_count(),
                start_s=_finite("where the free swing begins in the bag [s]"),
                duration_s=_finite("of the free swing [s]"),
                clock=_or_null(
                    _object(
                        "the device's clock, where the trial has its time",
                        fast=_finite("by how much it runs fast against ROS time, relative"),
                        std=_finite("standard deviation of that"),
                    )
                ),
                outliers_s=_list(_finite(), "when samples were left out as outliers, in the bag [s]", _MOST_OUTLIERS),
                weights=_list(
                    _object(
                        rod=_one_of(RODS),
                        mass=_finite("[kg]"),
                        place=_finite("distance of its centre from the rod's own joint [m]"),
                        inertia=_finite("about its own centre [kg m^2]"),
                        mass_std=_finite("standard deviation of the mass [kg]"),
                        place_std=_finite("of the place [m]"),
                    ),
                    "known weights that were clamped to the rods",
                ),
                warnings=_list(_text(), "what was cut or noticed"),
            ),
            "each bag",
        ),
        noise_rad=_object("of the encoders, estimated from the data", theta1=_finite("[rad]"), theta2=_finite("[rad]")),
        search=_object(
            "settings and course of the genetic search",
            method=_text(),
            cut_short=_flag("whether it was cut short, since a refinement follows"),
            seed=_count("of all chance"),
            population=_count(),
            generations=_count("of the last search"),
            searches=_count(),
            evaluations=_count("simulations of all searches"),
            sse=_number("its best error [rad^2]"),
            seconds=_finite("that it took [s]"),
            history=_list(_number(), "the best error by generation [rad^2]", _MOST_GENERATIONS),
            stopped=_text("why it ended"),
        ),
        stages=_object(
            "the error of the nominal values, of the search's best, and refined",
            nominal=_ERRORS,
            search=_ERRORS,
            refined=_ERRORS,
        ),
        before=_fit("the paper's model as fitted"),
        refinement=_object(
            "course of the refinement",
            iterations=_count(),
            simulations=_count(),
            converged=_flag(),
            windows=_object("by role", fit=_count(), holdout=_count()),
        ),
        effects=_list(_EFFECT, "each effect that was added", 100),
        after=_fit("the model with the effects"),
        unexplained=_object(
            "what remains",
            significant=_flag("whether it is more than noise"),
            joint=_text("in which it is"),
            times_noise=_number("how large it is"),
            description=_text("where it is"),
        ),
        verdict=_text("the result in one sentence"),
        prediction=_or_null(
            _object(
                "how far ahead the models predict, told the measured angles up to a start; null where trials are short",
                unseen=_flag("whether in trials that neither fit nor choice has seen"),
                starts=_count("from how many instants"),
                told_s=_finite("length of the motion before a start to which its state is fitted [s]"),
                horizon_s=_finite("how far ahead is predicted [s]"),
                time_s=_points(_finite(), "since the start [s]", AHEAD),
                before=_PREDICTION,
                after=_PREDICTION,
            )
        ),
        residuals=_object(
            "what is left in the residuals beside noise",
            interval_s=_finite("from one lag to the next [s]"),
            before=_WHITENESS,
            after=_WHITENESS,
        ),
        next_trial=_or_null(
            _object(
                "which trial to record next; null where the fit failed",
                assumed=_object(
                    "of the next trial: recorded and fitted as those before",
                    noise_rad=_finite("standard deviation of a whitened angle, were all independent [rad]"),
                    whitening=_pair(_pair(_finite()), "what makes the errors of both angles independent and alike"),
                    duration_s=_finite("of the free swing [s]"),
                    interval_s=_finite("between samples, as they are fitted [s]"),
                    window_s=_finite("length of the windows; 0 for as long as the motion can be followed [s]"),
                    shortest_window_s=_finite("[s]"),
                    half_width_s=_finite("of the local cubics that estimate the windows' initial states [s]"),
                    step_s=_finite("of the integrator [s]"),
                ),
                advice=_list(_ADVICE, "for what could be another effect, all groups, and each effect's strength"),
            )
        ),
        selection=_object(
            "what was tried at each step of the selection of effects, and what came of it",
            interrupted=_flag(),
            steps=_list(
                _object(
                    action=_text(),
                    rmse_fit_rad=_number("[rad]"),
                    rmse_validation_rad=_number("[rad]"),
                    tried=_list(
                        _object(
                            effects=_list(_one_of(tuple(effect.key for effect in CATALOGUE))),
                            rmse_fit_rad=_number("[rad]"),
                            rmse_validation_rad=_number("[rad]"),
                            delta_bic=_number(),
                        )
                    ),
                )
            ),
        ),
        continuity=_or_null(
            _object(
                "how well windows join",
                rms_rad=_number("[rad]"),
                relative=_number("about 1 where the model holds"),
                boundaries=_count("between windows"),
            )
        ),
        repeatability=_or_null(
            _object(
                "each trial's own estimate beside the joint one",
                agree=_flag("at 1 %"),
                p_value=_finite(),
                trials=_list(
                    _object(trial=_text(), groups=_object("its own estimate", **dict.fromkeys(_GROUPS, _ESTIMATE)))
                ),
            )
        ),
        new_trials=_list(
            _object(
                trial=_text(),
                rmse_rad=_number("[rad]"),
                expected_rmse_rad=_number("[rad]"),
                fits=_flag(),
                changed=_list(
                    _object(
                        name=_text(),
                        before=_number(),
                        alone=_number("by a fit of this trial alone"),
                        deviations=_number("standard deviations between them"),
                    )
                ),
            ),
            "with --watch: how each trial that came later fitted before it was seen",
        ),
        identifiability=_object(
            "what the trials determine",
            directions=_list(
                _object(singular_value=_number(), exponents=_map(_number())), "combinations, by how well they are seen"
            ),
            undetermined=_list(_text()),
            unseen_changes=_list(_CHANGES, "of groups, which no motion shows"),
            determined_physical=_list(_text()),
            physical_changes_without_effect=_list(_CHANGES, "of physical values"),
            to_measure=_list(_text(), "what would determine more"),
            words=_list(_text(), "the same for people"),
        ),
        warnings=_list(
            _object(name=_text(), about=_list(_text(), "what it is about"), message=_text()), "what is to be doubted"
        ),
        run=_object(
            "what is needed to repeat it",
            written_at=_text("ISO 8601"),
            seconds=_finite("that it took [s]"),
            versions=_map(_text(), "of the software"),
            options=_object(
                "every setting in effect, as in config/identify.yaml",
                tuple(name for name in KEYS if name not in _REQUIRED_OPTIONS),
                **{name: _KINDS[key.kind](key.description) for name, key in KEYS.items()},
            )
            | {"patternProperties": {f"^{re.escape(WEIGHTS)}": _list(_finite(), "see docs/how_to/weights.md", 3)}},
            bag_sha256=_map(_map(_text()), "of each bag's files, by their names"),
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


def outline(schema: Mapping[str, Any] = REPORT, name: str = "") -> Iterator[tuple[str, str, str]]:
    """Yield name, type and description of everything that a report may hold, for its documentation."""
    for inner in schema.get("anyOf", ()):
        if inner.get("type") != "null":
            yield from _outline_inside(inner, name)
    yield from _outline_inside(schema, name)


def document() -> str:
    """Return the text of docs/reference/report_schema.md."""
    rows = "".join(f"| `{name}` | {kind} | {about} |\n" for name, kind, about in outline())
    return _HEAD + rows


_HEAD = """\
# The schema of report.json

Strict JSON. `number or null`: null stands for a number that is not finite. `[]` is each element of a list, `.*` each
value of an object with names of its own, `a/b` two keys that hold alike things. Lists, texts and numbers have
limits, and nothing else may be there: `report` and `compare` refuse what contradicts this. The statement itself, a
JSON Schema, is `REPORT` in `cdp_ident/report/schema.py`.

| key | type | meaning |
|---|---|---|
"""


def _outline_inside(schema: Mapping[str, Any], name: str) -> Iterator[tuple[str, str, str]]:
    inside = {f"{name}.{keys}".lstrip("."): value for keys, value in _alike(schema.get("properties", {}))}
    for value in schema.get("patternProperties", {}).values():
        inside[f"{name}.{WEIGHTS}*"] = value
    if isinstance(schema.get("additionalProperties"), dict):
        inside[f"{name}.*"] = schema["additionalProperties"]
    if "items" in schema:
        inside[f"{name}[]"] = schema["items"]
    for key, value in inside.items():
        yield key, _type(value), value.get("description", "")
        yield from outline(value, key)


def _alike(properties: Mapping[str, Schema]) -> Iterator[tuple[str, Schema]]:
    """Yield what an object holds; keys whose values are alike, and are objects themselves, together."""
    for key, value in properties.items():
        keys = [other for other, schema in properties.items() if schema == value and "properties" in value]
        if not keys or key == keys[0]:
            yield "/".join(keys or [key]), value


def _type(schema: Mapping[str, Any]) -> str:
    if "enum" in schema:
        words = [f"`{word}`" if word else "empty" for word in schema["enum"]]
        return " or ".join(words) if len(words) <= 4 else f"one of {len(words)} words"
    if "anyOf" in schema:
        return " or ".join(_type(inner) for inner in schema["anyOf"])
    kind = schema.get("type", "")
    return " or ".join(kind) if isinstance(kind, list) else str(kind)
