"""Every constant that decides in tracing: what is accepted, dropped, exchanged, preferred and named.

Modules read them as attributes of this one, so that each stands here alone and a benchmark can change one in its own
process. Beneath each stands what it decides, its unit, and its origin. Tolerances of numerical methods and counts of
iterations and refits decide nothing but time; they stay where they are used.

A gain in variances is a fall of the squared error over the variance of the residuals' projection (`evidence.change`):
chi-squared distributed where the effect is absent. What chance alone gains is derived from one level, by Bonferroni's
inequality over all that is tried at a step. The other constants are tuned on hidden truths (`benchmarks/tracing.py`),
with other seeds than those whose results are stated, or are conventions.
"""

import math

from scipy.special import chdtri

from cdp_ident.model.effects.catalogue import known_effects

FAMILY_LEVEL = 0.01
"""Probability that chance gains enough anywhere among all that is tried: half of it for effects and pairs of effects,
half is left to instants.

Unit: probability. Origin: convention.
"""
INSTANT_GAIN = 60.0
"""Least fall of the fit's squared error by an effect of an instant.

Unit: variances. Origin: tuned; by chi-squared over all instants it would be 30, but correlated noise gains 55.
"""


def forms() -> int:
    """Return how many effects a score test is defined for, each form of one counted."""
    return sum(effect.has_score for effect in known_effects())


def least_gain(freedom: float) -> float:
    """Return what an effect of so many parameters, or a pair, must gain [variances]."""
    return float(chdtri(freedom, 0.5 * FAMILY_LEVEL / math.comb(forms() + 1, 2)))


def least_score(freedom: float) -> float:
    """Return what an effect of so many parameters must gain in the score test to be refitted [variances]."""
    return float(chdtri(freedom, FAMILY_LEVEL / forms()))


VALIDATION_GAIN = 8.0
"""Least fall of the squared validation error by an effect; one of an instant may raise it by as much.

Unit: variances. Origin: tuned; by chance it would rise.
"""
VALIDATION_SHARE = 0.01
"""Least fall of the validation error by an effect.

Unit: share of it. Origin: tuned: smaller ones may be a part of another effect.
"""
CERTAIN = 60.0
"""Fall of the squared validation error that is enough even if its share is smaller.

Unit: variances. Origin: tuned: in short windows a certain effect may cause only a small share of the error.
"""
NOISE_MEMORY = 0.1
"""Residuals with a longer integrated correlation time contain more than noise with a memory: effects must then improve
the model by more. Residuals above the noise with a shorter one are noise.

Unit: sqrt(L / g). Origin: tuned; rods move over several units.
"""
STRUCTURED_SHARE = 0.05
"""Least fall of the error, in the fit or in validation, where more than noise would remain.

Unit: share of it. Origin: tuned: a small gain may be due to another effect.
"""
STILL_HELPS = 0.5
"""An effect stays beside later ones if it gains this share of what a new one must.

Unit: share. Origin: tuned: what came in is not to go out by chance.
"""
SAFE = 10.0
"""An effect of greater strength is not tested again beside later ones.

Unit: its standard deviations. Origin: tuned; it saves time.
"""
PAIR_GAINS = 1.2
"""Two effects are tried together if in the score test they gain so many times the sum of what each gains.

Unit: ratio. Origin: tuned.
"""
NEAR_THE_BEST = 0.75
"""An addition that gains this share of what the best one does is preferred if it has fewer parameters.

Unit: share. Origin: tuned.
"""
CORRELATED_BELOW = 0.3
"""A score test takes residuals for as correlated as they are where its gain is a smaller share of the squared error;
with a larger one, they are so because the effect is missing.

Unit: share. Origin: tuned.
"""
NEAR_A_RIVAL = 0.5
"""A rival of an effect is refitted if it gains this share of its gain in the score test; a small gain of a
richer form is its own if nothing that is missing gains this share of it.

Unit: share. Origin: tuned.
"""
INDISTINGUISHABLE = 9.0
"""Models whose squared validation errors differ by less are both possible.

Unit: variances. Origin: three standard deviations.
"""
SLIP_LEAVES = 0.5
"""Largest share of the squared error that lost counts may leave where more than noise would remain.

Unit: share. Origin: tuned: lost counts affect all windows from then on.
"""
HARMONIC_LEAVES = 0.15
"""Largest share of the squared error that one harmonic may leave where more than noise would remain.

Unit: share. Origin: tuned: of another function of position one harmonic leaves a third and more.
"""
OUTLIER = 6.0
"""An impulse is in a window whose mean squared error is so far above the others'.

Unit: its standard deviations. Origin: tuned.
"""
LIKE_THE_OTHERS = 1.7
"""With the impulse, that window's mean squared error is at most so many times the others'.

Unit: ratio. Origin: tuned.
"""
IMPULSE_ALONE = 10.0
"""An impulse explains so many times as much as any other one would in addition, or it imitates a lasting effect.

Unit: ratio. Origin: tuned.
"""
AWAY = 50
"""An effect of an instant explains the residual better, by what a new effect must, than one so far away.

Unit: samples. Origin: tuned.
"""
LEAST_STEPS = 0.75
"""An encoder's offset, or counts that it lost, count as more than rounding from so many of its steps on.

Unit: steps. Origin: half a step is rounding.
"""
LARGE_SHARE = 0.1
"""Least fall of the validation error by a torque without a name, by effects other than those that longer windows showed
and, where more than noise would remain, by zeros of each trial.

Unit: share of it. Origin: tuned: a smaller one may be one of many small effects.
"""
AS_GOOD = 1.02
"""A model is as good as one with a curve if its validation error is at most so many times the other's.

Unit: ratio. Origin: tuned.
"""
CURVE_NEAR_THE_BEST = 0.3
"""A curve is fitted if it gains this share of what the best curve gains in the score test.

Unit: share. Origin: tuned; it saves time.
"""
NAMED = 1.5
"""Least ratio of the error that an effect explains to the error that remains, for a name.

Unit: ratio of squared errors. Origin: tuned.
"""
NAMED_WITH_OTHERS = 0.5
"""The same of an effect that with other weak ones explains enough for a name.

Unit: ratio of squared errors. Origin: tuned.
"""
NOISE_KNOWN_WITHIN = 0.02
"""At least this share of the noise counts as an error that remains.

Unit: share. Origin: how well 1000 to 3000 samples show a standard deviation.
"""
ABOVE_NOISE = 1.2
"""From an error of so many times the noise on more than noise remains: then curves are tried, and effects combined that
fail alone.

Unit: ratio. Origin: tuned.
"""
WINDOW_ABOVE_OTHERS = 3.0
"""A window with so many times the error of the others is mentioned.

Unit: ratio. Origin: convention.
"""
ALIKE = 0.8
"""Least share of a curve's mean square that a known shape explains to be mentioned.

Unit: share. Origin: convention.
"""
ALIKE_BY_MORE = 0.03
"""What another shape must explain more to be preferred to a simpler one.

Unit: share. Origin: tuned.
"""
