# Copyright 2026 cdp_ident maintainers
# SPDX-License-Identifier: Apache-2.0
"""Reasons to doubt an identification, each with a name."""

from collections.abc import Iterable, Iterator
from dataclasses import dataclass

import numpy as np

from cdp_ident.diagnosis.identification import Identification
from cdp_ident.fit.initial_states import OUTLIER
from cdp_ident.model.parameters import CONSTANTS, GROUPS, SYMBOLS
from cdp_ident.trial.kinematics import MEDIAN_OF_SIZE
from cdp_ident.trial.outliers import outlier_words
from cdp_ident.trial.trial import Trial

_EDGE = 0.01
"""A value within this share of its search range from a limit is at its edge."""
FAR_OFF = 3.0
"""A value is wrong that is so many standard deviations off; an error is far too large that is so many times the noise,
or the median of the windows."""
MOST_NAMED = 4
_DAMAGED = 0.02
"""A larger share of outliers means that a part is broken; of more than a few per cent, some are not found."""


@dataclass(frozen=True)
class FitWarning:
    """One reason for doubt."""

    name: str
    """What kind it is, always the same for one kind."""
    about: tuple[str, ...]
    """The parameters, trials or windows concerned."""
    message: str
    """The reason in a sentence, with numbers."""


def find_warnings(identification: Identification) -> list[FitWarning]:
    """Return every reason to doubt an identification, the gravest first."""
    return [
        *_unsound(identification),
        *_constants(identification),
        *_weights(identification),
        *_differs_by_trial(identification),
        *_above_noise(identification),
        *_disagreement(identification),
        *_windows(identification),
        *_edges(identification),
        *_frictions(identification),
        *_outliers_of_the_fit(identification),
    ]


def outlier_warnings(trials: Iterable[Trial]) -> list[FitWarning]:
    """Return which of the trials, as they were loaded, had outliers, and which so many that they are damaged."""
    warnings = []
    for trial in trials:
        count, samples = len(trial.outliers), len(trial.time)
        if count:
            damaged = count > _DAMAGED * (count + samples)
            message = f"{trial.name}: {outlier_words(trial.outliers, samples)}"
            message += ": so many that the recording is damaged, or an encoder or its cable" if damaged else ""
            warnings.append(FitWarning("outliers", (trial.name,), message))
    return warnings


def _unsound(found: Identification) -> Iterator[FitWarning]:
    if not found.search.completed:
        yield FitWarning("interrupted", (), f"the search was ended early ({found.search.stopped})")
    if not found.whole.converged:
        steps = found.whole.steps
        yield FitWarning("not_converged", (), f"the fit to whole swings had not converged after {steps} steps")
    if not found.physical.possible:
        yield FitWarning(
            "no_possible_mechanism",
            (),
            "no masses, lengths and inertias that rods can have were found for the fitted base parameters: check L, "
            "the known and nominal values, and what the joints' angles mean",
        )


def _constants(found: Identification) -> Iterator[FitWarning]:
    model, units = found.fit.model, {constant.symbol: constant.unit for constant in CONSTANTS}
    fitted = zip(model.base_names, found.fit.values, *model.known, strict=False)
    seen = {name: (value, given, precision**-0.5) for name, value, given, precision in fitted if precision > 0.0}
    if not {"L", "g"} & set(seen) and np.isfinite(found.options.length_std):
        # L was said to be exact, or is so far off that it was not believed. Motion shows L / g.
        value, std = found.length_by_motion
        seen["L"] = value, model.mechanism.length, std
    for name, (value, given, std) in seen.items():
        if name in units and (off := abs(value - given) / std) > FAR_OFF:
            where = f"{off:.1f} standard deviations from the {given:g} {units[name]} that were given"
            words = f"by the motion {name} is {value:.5g} {units[name]}, {where}: measure it again"
            yield FitWarning("constant_off", (name,), words)


def _weights(found: Identification) -> Iterator[FitWarning]:
    errors = found.fit.values[found.fit.model.of_weights]
    for trial in found.data.trials:
        for weight in trial.weights:
            actual = weight.with_errors(dict(zip(found.fit.model.weight_errors, errors.tolist(), strict=True)))
            off = (actual.place - weight.place) / weight.place_std if weight.place_std else 0.0
            if abs(off) > FAR_OFF:
                yield FitWarning(
                    "weight_off",
                    (trial.name,),
                    f"by the motion the weight on the {weight.rod} rod in {trial.name} is at {actual.place:.4g} m, "
                    f"{abs(off):.1f} standard deviations from the {weight.place:g} m that were given: measure its "
                    "place again",
                )


def _differs_by_trial(found: Identification) -> Iterator[FitWarning]:
    model, names = found.fit.model, found.data.names
    if model.zeros:
        encoders = f"{' and '.join(model.zero_joints)} encoder{'s' * (len(model.zero_joints) > 1)}"
        words = ", ".join(
            " and ".join(f"{zero:+.2g}" for zero in np.degrees(found.fit.values[model.zero_places(trial)]))
            + f" in {names[trial]}"
            for trial in model.zeros
        )
        yield FitWarning(
            "zeros_by_trial",
            tuple(names[trial] for trial in model.zeros),
            f"the zeros of the {encoders} differ from trial to trial (degrees: {words}); each trial's "
            "are fitted along with it. Let the rods hang still when the zero is taken, or take it once for all trials",
        )
    for active in model.effects:
        if active.trial is not None and active.is_difference:
            name = names[active.trial]
            yield FitWarning(
                "differs_by_trial",
                (name,),
                f"{active.effect.description} ({active.effect.joint}) differs from trial to trial: that of {name} is "
                "another one, and how large it is in the next trial, nobody knows. A joint may have warmed up, or "
                "something was changed in between",
            )


def _above_noise(found: Identification) -> Iterator[FitWarning]:
    noise = found.whole.noise_level(found.data.noise)
    error = found.fit.rmse()
    if error > FAR_OFF * noise:
        yield FitWarning(
            "error_above_noise",
            (),
            f"the error of {1e3 * error:.3g} mrad is {error / noise:.1f} times the encoders' noise: the model lacks "
            "something, or L, g or the nominal values are far off",
        )


def _disagreement(found: Identification) -> Iterator[FitWarning]:
    compared = found.repeatability
    if compared is None or compared.agree:
        return
    apart = np.ptp(compared.values, axis=0)
    with np.errstate(divide="ignore", invalid="ignore"):
        worst = int(np.argmax(np.nan_to_num(apart / np.sqrt(np.sum(compared.std**2, axis=0)))))
    name = compared.names[worst]
    joint = abs(float(found.fit.values[found.fit.model.names.index(name)]))
    spread = float(apart[worst]) / max(joint, np.finfo(float).tiny)
    weights = any(trial.weights for trial in found.data.trials)
    asked = ". Are the weights where they are said to be, and as heavy?" if weights else ""
    yield FitWarning(
        "trials_disagree",
        (name, *compared.trials),
        f"the trials disagree (p = {compared.p_value:.2g}), most about {name}: alone they give values "
        f"{100 * spread:.2g} % apart; the standard deviations do not cover that{asked}",
    )


def _windows(found: Identification) -> Iterator[FitWarning]:
    errors = np.array([np.sqrt(np.mean(error**2)) for error in found.fit.errors])
    usual = float(np.median(errors))
    for place in np.argsort(-errors, kind="stable")[:MOST_NAMED]:
        if not errors[place] >= FAR_OFF * usual > 0.0:
            return
        window = found.fit.windows[place]
        trial = found.data.trials[window.trial]
        begin = trial.start + window.begin
        where = f"{trial.name} from {begin:.2f} to {begin + window.duration:.2f} s"
        yield FitWarning(
            "window_fits_worse",
            (where,),
            f"{where} fits far worse than the others: {1e3 * errors[place]:.3g} mrad, the median is "
            f"{1e3 * usual:.3g} mrad; look for an impulse or lost counts of an encoder there",
        )


def _edges(found: Identification) -> Iterator[FitWarning]:
    if not found.physical.possible:
        return
    for symbol, value, low, high in zip(SYMBOLS, found.physical.values, *found.options.prior.box, strict=True):
        margin = _EDGE * (high - low)
        if margin == 0.0 or value == 0.0 or low + margin < value < high - margin:
            continue
        edge, limit = ("lower", low) if value <= low + margin else ("upper", high)
        where = "at" if low - margin <= value <= high + margin else "beyond"
        yield FitWarning(
            f"{where}_limit",
            (symbol,),
            f"{symbol} = {value:.4g} is {where} its {edge} limit {limit:.4g}: is its nominal value right?",
        )


def _frictions(found: Identification) -> Iterator[FitWarning]:
    for group, value in zip(GROUPS, found.fit.values, strict=False):
        if group.symbol.startswith("c") and value <= 0.0:
            symbol = group.symbol.partition("_")[0]
            yield FitWarning(
                "friction_at_zero",
                (symbol,),
                f"{symbol} came out as zero, which no joint has: other friction than viscous may be at work",
            )


def _outliers_of_the_fit(found: Identification) -> Iterator[FitWarning]:
    trials = found.data.trials
    outlying = [0] * len(trials)
    total = [0] * len(trials)
    sizes = [np.abs(error) for error in found.fit.errors]
    limit = OUTLIER * float(np.median(np.concatenate(sizes))) / MEDIAN_OF_SIZE
    for window, size in zip(found.fit.windows, sizes, strict=True):
        outlying[window.trial] += int(np.count_nonzero(np.max(size, axis=1) > limit))
        total[window.trial] += len(size)
    for trial, count, samples in zip(trials, outlying, total, strict=True):
        if count:
            yield FitWarning(
                "outliers_of_the_fit",
                (trial.name,),
                f"{count} of {samples} samples of {trial.name} are far off the model and count for less",
            )
