"""From the search box to the minimum: the genetic search, short or in full, and the refinement of its best.

A second refinement begins at the base parameters of a balance of forces; the better fit is taken.
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from itertools import groupby

import numpy as np
import numpy.typing as npt

from cdp_ident.errors import IdentificationError
from cdp_ident.fit.motion_model import MotionModel
from cdp_ident.fit.prior import Prior
from cdp_ident.fit.refinement import Fit, refine_from_afar
from cdp_ident.fit.windows import Window
from cdp_ident.model.parameters import coefficients_of, groups_of, inertia_about_cart
from cdp_ident.model.population import Population, Segment
from cdp_ident.model.weights import Weight, added_by
from cdp_ident.search.genetic_search import Progress, SearchResult, genetic_search
from cdp_ident.search.options import IGA, GeneticOptions

Array = npt.NDArray[np.float64]

SHORT_IGA = replace(IGA, population=64, generations=2)
"""The improved algorithm cut short: the refinement finds the minimum from its result."""
PAPER_SPAN = 10.0
"""How long one simulation of the paper's search is [s] (Section 4.2)."""
_FAR_ABOVE_NOISE = 10.0
"""An error of so many times the noise may mean that the search missed the global minimum's basin; it is then
repeated."""
_MOST_SEARCHES = 4
_SAME_BASIN = 0.01
"""Two fits whose errors differ by less than this share are taken for the same minimum."""
_NO_BETTER = 1e-6
"""The fit from the balance must be better by this share of the error to be taken."""


@dataclass(frozen=True)
class Estimate:
    """The outcome of search and refinement."""

    search: SearchResult
    """The search that led to the fit."""
    searches: int
    """How many searches it took."""
    evaluations: int
    """Chromosomes evaluated in all of them."""
    fit: Fit
    starting_values: str = "search"
    """Where the fit's initial values are from: the search, or the balance of forces."""


def search_objective(windows: Sequence[Window], span: float, prior: Prior) -> Callable[[Array], Array]:
    """Return Eq. (10) as a function of chromosomes (n, 9), over segments of the windows' trials.

    Args:
        windows: the windows whose samples count, in the order of time; those held out are not among them.
        span: length of a segment [s]: from the initial state of one window, the motion is simulated for so long.
        prior: gives L and g.
    """
    segments: dict[tuple[Weight, ...], list[Segment]] = {}
    for _, of_trial in groupby(windows, key=lambda window: window.trial):
        run: list[Window] = []
        for window in of_trial:
            if run and window.begin + window.duration - run[0].begin > span * (1 + 1e-3) + 0.5 * window.duration:
                segments.setdefault(window.weights, []).append(_segment(run))
                run = []
            run.append(window)
        segments.setdefault(run[0].weights, []).append(_segment(run))
    populations = {weights: Population(alike, windows[0].grid.step) for weights, alike in segments.items()}

    def objective(chromosomes: Array) -> Array:
        error = np.zeros(len(chromosomes))
        for weights, population in populations.items():
            coefficients = weighted_coefficients(chromosomes, weights, prior)
            inertia = inertia_about_cart(chromosomes, prior.length) + added_by(weights, prior.length)[0]
            error += population.squared_errors(coefficients, inertia).sum(axis=1)
        return error

    return objective


def weighted_coefficients(chromosomes: Array, weights: tuple[Weight, ...], prior: Prior) -> Array:
    """Return the coefficients (n, 7) of chromosomes (n, 9) with weights on the rods; the prior gives L and g."""
    length = prior.length
    groups, inertia = groups_of(chromosomes, length), inertia_about_cart(chromosomes, length)[:, None]
    added = added_by(weights, length)
    weighted = (inertia * groups + added[1:]) / (inertia + added[0]) if weights else groups
    return coefficients_of(weighted, length, prior.gravity)


def _segment(run: Sequence[Window]) -> Segment:
    beginning = run[0].begin
    torques = [window.torques for window in run if window.torques is not None]
    return Segment(
        start=run[0].start,
        time=np.concatenate([window.begin - beginning + window.time for window in run]),
        theta=np.concatenate([window.theta for window in run]),
        cart_acceleration=np.concatenate([window.cart_acceleration for window in run]),
        torques=np.concatenate(torques) if len(torques) == len(run) else None,
    )


def estimate(
    model: MotionModel,
    windows: Sequence[Window],
    prior: Prior,
    noise: float,
    rng: np.random.Generator,
    options: GeneticOptions = SHORT_IGA,
    span: float = 0.0,
    stop: Callable[[Progress], str | None] = lambda progress: None,
    balanced: Array | None = None,
) -> Estimate:
    """Search the prior's box, refine the best, and search again where another minimum may be better.

    A second fit begins at the base parameters of a balance of forces, and the better one is taken.

    Args:
        model: what to fit.
        windows: what to fit it to.
        prior: the search's box, and L and g.
        noise: standard deviation of the measured angles' noise [rad].
        rng: the only source of chance.
        options: the genetic algorithm.
        span: how long the search simulates from one initial state [s]; one window at least.
        stop: called after each generation of a search; a sentence that it returns ends the searching.
        balanced: (unknowns,) what a balance of forces has found.

    Raises:
        IdentificationError: there is no window to fit, or the motion cannot be computed from anything that was found.
    """
    if not windows:
        raise IdentificationError("there is nothing to fit: no window of any trial has enough samples")
    objective = search_objective(windows, span, prior)
    lower, upper = prior.box
    best: Estimate | None = None
    from_balance = None if balanced is None else _refined(model, balanced, windows)
    evaluations = 0
    for attempt in range(1, _MOST_SEARCHES + 1):
        longer = replace(options, generations=options.generations * 2 ** (attempt - 1))
        search = genetic_search(objective, lower, upper, longer, rng, stop)
        evaluations += search.evaluations
        inertia = float(inertia_about_cart(search.best, prior.length))
        of_search = _refined(model, model.initial_values(groups_of(search.best, prior.length), inertia), windows)
        fit = of_search or from_balance
        if fit is None:
            if not search.completed:
                break
            continue
        before = best.fit.rmse() if best else np.inf
        if best is None or fit.rmse() < before:
            best = Estimate(search, attempt, evaluations, fit)
        is_balanced = best.fit is from_balance
        if from_balance and (is_balanced or from_balance.rmse() < (1.0 - _NO_BETTER) * best.fit.rmse()):
            best = replace(best, fit=from_balance, starting_values="balance of forces")
        arrived = best.fit.rmse() < _FAR_ABOVE_NOISE * noise
        other = before if from_balance is None else min(before, from_balance.rmse())
        agree = abs(fit.rmse() - other) < _SAME_BASIN * other < np.inf
        if arrived or agree or not search.completed:
            break
    if best is None:
        raise IdentificationError(
            f"the model's motion cannot be computed from the best values of any of {attempt} searches: check L, g and "
            "the nominal values"
        )
    return replace(best, searches=attempt, evaluations=evaluations)


def _refined(model: MotionModel, values: Array, windows: Sequence[Window]) -> Fit | None:
    """Return the fit that begins at values (unknowns,); None where it cannot be computed."""
    try:
        return refine_from_afar(model, values, windows)
    except IdentificationError:
        return None
