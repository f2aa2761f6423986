"""Which candidates get a full refit: by score tests on the windows and on short pieces of them.

In chaotic motion, the residual is not linear in the missing effects; over short pieces it is, but there small effects
are below the noise.
"""

from collections import Counter
from collections.abc import Sequence

from cdp_ident.fit.refinement import Fit
from cdp_ident.tracing import thresholds
from cdp_ident.tracing.candidates import Candidate, Pair, ScoreTest
from cdp_ident.tracing.evidence import Attempt

_HARMONICS = 3
"""Of each joint, so many harmonics are refitted at most by each of the two tests."""


def promising(attempt: Attempt, test: ScoreTest, most: int, rival_of: Sequence[str] = ()) -> list[Candidate]:
    """Return the candidates to be refitted.

    Args:
        attempt: the model that they could be added to.
        test: of the candidates over its windows.
        most: how many at most, by each of the two tests.
        rival_of: keys of some of them; only those are returned that gain at least half of what any of these does.
    """
    nearby = ScoreTest(attempt.closely, test.candidates)
    found: dict[str, Candidate] = {}
    for ranking, fit in ((test.ranked(), attempt.fit), (nearby.ranked(), attempt.closely)):
        least = thresholds.NEAR_A_RIVAL * max((c.gain for c in ranking if c.active.effect.key in rival_of), default=0.0)
        worth = [c for c in ranking if c.gain > least and is_worth_a_look(fit, c)]
        for candidate in _with_few_harmonics(worth)[:most]:
            # What oscillates is refitted from short pieces on, so its frequency is to be that of short pieces.
            if candidate.active.effect.key not in found or candidate.active.effect.brings_states:
                found[candidate.active.effect.key] = candidate
    return list(found.values())


def _with_few_harmonics(ranking: Sequence[Candidate]) -> list[Candidate]:
    """Return candidates without all but each joint's best harmonics: many imitate the same and leave no room."""
    left, seen = [], Counter[str]()
    for candidate in ranking:
        effect = candidate.active.effect
        seen[effect.joint] += effect.harmonic
        if not effect.harmonic or seen[effect.joint] <= _HARMONICS:
            left.append(candidate)
    return left


def is_worth_a_look(fit: Fit, candidate: Candidate) -> bool:
    """Return whether a candidate gains so much in the score test that it is refitted."""
    least = thresholds.least_score(candidate.freedom)
    return candidate.gain > least * expected_variance(fit, candidate.gain, candidate.variance_ratio)


def gains_enough(fit: Fit, pair: Pair) -> bool:
    """Return whether two candidates together gain in the score test what they must gain in a fit."""
    least = thresholds.least_gain(pair.freedom)
    return pair.gain > least * expected_variance(fit, pair.gain, pair.variance_ratio)


def expected_variance(fit: Fit, gain: float, ratio: float | None = None) -> float:
    """Return the variance of the residuals' projection on what is added, after a gain [rad^2].

    Args:
        fit: the fit before.
        gain: the fall of its squared error [rad^2].
        ratio: that variance over the one of white residuals; where it is not at hand, that of a mean, the integrated
            autocorrelation time.
    """
    left = max(fit.squared_error - gain, 0.05 * fit.squared_error)
    ratio = fit.autocorrelation.integrated_time if ratio is None else ratio
    # The residual is correlated otherwise once the effect is there, but for small gains.
    small = gain < thresholds.CORRELATED_BELOW * fit.squared_error
    return left / fit.samples * (ratio if small else 1.0)
