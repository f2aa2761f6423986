"""The paper's two genetic algorithms side by side: evolution, contrast curves and angular errors."""

from collections.abc import Iterator

import numpy as np

from cdp_ident.report.figures.description import Axis, Figure, Line, Panel
from cdp_ident.report.figures.errors import GENERATION, evolution
from cdp_ident.report.figures.motion import file_name, measured_and_simulated
from cdp_ident.report.searches import Algorithm, Searches, fitness
from cdp_ident.report.wording import Model


def search_figures(searches: Searches) -> Iterator[Figure]:
    """Yield the evolution of all searches, then each trial as the typical search of each algorithm follows it."""
    first, other = searches.algorithms
    shown = {Model("before", first.name): first, Model("after", other.name): other}
    errors, fitnesses = ([line for pair in shown.items() for line in _lines(*pair, of)] for of in ("E", "H"))
    generations = errors[0].x
    floor = np.full(len(generations), searches.noise_error)
    ends = [f"{a.name} from {a.courses[0].end.error:.3g} to {a.courses[-1].end.error:.3g} rad²" for a in shown.values()]
    yield Figure(
        "evolution",
        "Evolution of the best chromosome",
        f"Best error and its fitness (Eq. 7) after each generation: thin, each of {len(first.courses)} searches, which "
        "differ by the seed; thick, their median. As the paper's Figs. 7, 9 and 13, which show one search each.",
        f"Best errors after the last generation: {'; '.join(ends)}.",
        [
            evolution([*errors, Line("the encoders' noise alone", "noise", generations, floor, dashed=True)]),
            Panel(GENERATION, Axis("fitness H(Z)"), fitnesses),
        ],
        shared_x=True,
    )
    for number, (name, window) in enumerate(zip(searches.trials, searches.windows, strict=True)):
        yield measured_and_simulated(
            f"contrast_{number + 1}_{file_name(name)}",
            f"{name}: measured and simulated, and angular errors",
            "One simulation from the trial's first instant with the best chromosome of a typical search of each. "
            "As the paper's Figs. 8, 10, 11 and 12.",
            window.time,
            window.theta,
            {Model(m.key, f"{a.name}, seed {a.typical.seed}"): a.simulated[number] for m, a in shown.items()},
        )


def _lines(model: Model, algorithm: Algorithm, of: str) -> Iterator[Line]:
    """Yield a line for each search and one for their median: of the errors, or of the fitness H."""
    errors = np.array([[one.error for one in course.generations] for course in algorithm.courses])
    generations = np.arange(errors.shape[1], dtype=float)
    every, median = (
        fitness(some, algorithm.options) if of == "H" else some for some in (errors, np.median(errors, axis=0))
    )
    for values in every:
        yield Line(f"{model.label}, each seed", model.key, generations, values, 0.6)
    yield Line(f"{model.label}, median", model.key, generations, median, 3.0)
