# Copyright 2026 cdp_ident maintainers
# SPDX-License-Identifier: Apache-2.0
"""The settings of the genetic search, all in one place: the paper's."""

from dataclasses import dataclass

from cdp_ident.errors import OptionError


@dataclass(frozen=True)
class GeneticOptions:
    """How the genetic search works; the defaults are those of the improved algorithm, IGA (Section 4.3).

    The five improvements can be switched off one by one, to see what each is worth. All of them off, with `TGA`'s
    rates, is the traditional algorithm.
    """

    population: int = 200
    """M, chromosomes in a generation."""
    generations: int = 500
    """Generations at most."""
    crossover_rate: float = 0.2
    """Pc: M Pc / 2 pairs are crossed in a generation."""
    mutation_rate: float = 0.02
    """Pm: M Pm chromosomes are mutated in a generation."""

    hamming_pairing: bool = True
    """Pairs that differ in one gene at most are not crossed; one of them is replaced by a new one (Section 3.1)."""
    variable_precision: bool = True
    """The gene at the crossover point takes values between the parents' and on a grid over its range (Section 3.2)."""
    orthogonal_experiments: bool = True
    """The best combination of two offspring's genes is found by an orthogonal array (Section 3.3)."""
    feedback_mutation: bool = True
    """Once the population has become alike, mutants are made near its best chromosome (Section 3.4)."""
    logarithmic_fitness: bool = True
    """Fitness for the roulette is the logarithm of the error (Section 3.5); if not, its inverse."""
    elitist_survival: bool = True
    """Parents and offspring compete for the next generation (Steps 8 and 9); if not, offspring replace parents."""

    feedback_threshold: float = 0.95
    """alpha: population fitness (Eq. 5) above which mutation is by feedback."""
    feedback_scale: float = 0.95
    """mu of Eq. (6)."""
    feedback_spread: float = 0.10
    """nu of Eq. (6)."""
    fitness_offset: float = 32.0
    """delta of Eq. (7)."""
    fitness_error_limit: float = 1000.0
    """C of Eq. (7) [rad^2]: all errors above it are equally bad.

    The paper gives it no value. With delta = 32 it must lie below 10^3.2 = 1585 for the fitness to be positive; at
    1000 the worst chromosomes keep a sixteenth of the chance of a good one.
    """

    def __post_init__(self) -> None:
        """Refuse settings that the algorithm has no meaning for."""
        ranges = {
            "population": (4, 100_000),
            "generations": (0, 1_000_000),
            "crossover_rate": (0.0, 1.0),
            "mutation_rate": (0.0, 1.0),
            "feedback_threshold": (0.0, 1.0),
            "feedback_scale": (0.0, 1.0),
            "feedback_spread": (0.0, 1.0),
            "fitness_offset": (0.0, 1000.0),
        }
        for name, (lowest, highest) in ranges.items():
            value = getattr(self, name)
            if not lowest <= value <= highest:
                raise OptionError(f"search option {name} is {value}; it must be between {lowest} and {highest}")
        highest_limit = 10 ** (self.fitness_offset / 10)
        if self.logarithmic_fitness and not 0 < self.fitness_error_limit < highest_limit:
            raise OptionError(
                f"search option fitness_error_limit is {self.fitness_error_limit}; with fitness_offset "
                f"{self.fitness_offset} it must be above 0 and below {highest_limit:.4g} for fitness to stay positive"
            )


IGA = GeneticOptions()
"""The improved algorithm with the settings of Section 4.3."""

TGA = GeneticOptions(
    crossover_rate=1.0,
    mutation_rate=0.1,
    hamming_pairing=False,
    variable_precision=False,
    orthogonal_experiments=False,
    feedback_mutation=False,
    logarithmic_fitness=False,
    elitist_survival=False,
)
"""The traditional algorithm with the settings of Section 4.2."""

METHODS = {"iga": IGA, "tga": TGA}
