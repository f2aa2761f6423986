"""Which candidates get a full refit: by score tests on the windows and on short pieces of them.

In chaotic motion, the residual is not linear in the missing effects; over short pieces it is, but there small effects
are below the noise.
"""

from collections.abc import Sequence

from cdp_ident.fit.refinement import Fit
from cdp_ident.tracing import thresholds
from cdp_ident.tracing.candidates import Candidate, ScoreTest
from cdp_ident.tracing.evidence import Attempt


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
        worth = [c for c in ranking if c.gain > max(thresholds.WORTH_A_LOOK * expected_variance(fit, c.gain), least)]
        for candidate in worth[:most]:
            found.setdefault(candidate.active.effect.key, candidate)
    return list(found.values())


def expected_variance(fit: Fit, gain: float) -> float:
    """Return the variance that one independent residual would have after a gain [rad^2]."""
    left = max(fit.squared_error - gain, 0.05 * fit.squared_error)
    # The residual is correlated otherwise once the effect is there, but for small gains.
    small = gain < thresholds.CORRELATED_BELOW * fit.squared_error
    return left / fit.samples * (fit.autocorrelation.integrated_time if small else 1.0)
