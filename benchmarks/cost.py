# Copyright 2026 cdp_ident maintainers
# SPDX-License-Identifier: Apache-2.0
"""What an identification costs.

Over samples, trials, rate and effects. Simulated trials of the paper's rig, let go from rest, with 2 mrad of noise and
encoders of 8000 counts; medians over seeds. Times are CPU times: of identifying the paper's model, and of the search
for effects that follows, where nothing is hidden and where dry friction is hidden in the outer joint.
"""

import statistics
import time
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np

from benchmarks._tables import Table, number, whole
from benchmarks._workers import LIMIT, alone, each
from cdp_ident.fit.options import IdentifyOptions
from cdp_ident.fit.prior import Prior
from cdp_ident.machine.parallel import core_count
from cdp_ident.model.effects.catalogue import CATALOGUE
from cdp_ident.model.effects.curves import CURVES
from cdp_ident.pipeline.identify import identify
from cdp_ident.tracing.trace import trace
from cdp_ident.trial.trial import Trial
from reference.dry_friction import NO_FRICTION, DryFriction
from reference.pendulum import TABLE_5
from reference.sticking import motion
from reference.torques import SPRING, Torque
from scenarios.twin import as_measured

SEEDS = 3
STARTS = ((2.2, 2.0), (2.4, 4.5), (4.0, 4.4), (1.9, 3.4))
"""Where the hand lets go, theta1 and theta2 [rad]; by turns."""
FRICTION = DryFriction(torque=1.9e-3)
SPRING_INNER = Torque(SPRING, "inner", (0.01, 0.0))
"""Hidden second: a cable's stiffness [N m / rad]."""
MEASURED = Path(__file__).parents[2] / "shared" / "data" / "multiarm_free_swing" / "free_swing_8s_56s_1kHz.csv.gz"
MEASURED_RIG = IdentifyOptions(prior=Prior(nominal={"L": 0.17272}), length_std=np.inf)


@dataclass(frozen=True)
class Case:
    """What is identified."""

    trials: int = 2
    duration: float = 10.0
    """Of each [s]."""
    rate: int = 200
    """Samples a second."""
    hidden: int = 0
    """How many effects there are: dry friction, and a spring."""
    named_only: bool = False
    """Whether nonparametric torques are not looked for."""

    def measured(self, seed: int) -> list[Trial]:
        """Return its trials."""
        rng = np.random.default_rng(seed)
        clock = np.arange(round(self.duration * self.rate)) / self.rate
        trials = []
        for count in range(self.trials):
            angles = np.array(STARTS[count % len(STARTS)]) + rng.normal(scale=0.05, size=2)
            states = motion(
                TABLE_5,
                [*angles, 0.0, 0.0],
                clock,
                outer=FRICTION if self.hidden else NO_FRICTION,
                torques=[SPRING_INNER] if self.hidden > 1 else [],
            )
            trials.append(Trial(f"swing_{count}", clock, as_measured(states[:, :2], rng)))
        return trials


BASE = Case()
TABLES: Mapping[str, Mapping[str, Case]] = {
    "Over length, two trials of 200 Hz": {f"{t:g} s": replace(BASE, duration=t) for t in (5.0, 10.0, 20.0)},
    "Over trials of 10 s at 200 Hz": {str(n): replace(BASE, trials=n) for n in (1, 2, 4)},
    "Over rate, two trials of 10 s": {f"{hz} Hz": replace(BASE, rate=hz) for hz in (100, 200, 1000)},
}


@dataclass(frozen=True)
class Cost:
    """What a case cost."""

    case: Case
    identify: float = 0.0
    """CPU time of identifying the paper's model [s]."""
    trace: float = 0.0
    """CPU time of the search for effects [s]."""
    failure: str = ""


def tables(quick: bool = False) -> list[Table]:
    """Identify all cases, as many at a time as there are cores, each on one; a quick run has one seed."""
    plain = [case for cases in TABLES.values() for case in cases.values()]
    both = [replace(case, hidden=hidden) for case in plain for hidden in (0, 1)]
    catalogue = [replace(BASE, hidden=hidden, named_only=only) for hidden in (0, 1, 2) for only in (True, False)]
    jobs = [(case, seed) for seed in range(1 if quick else SEEDS) for case in dict.fromkeys([*both, *catalogue])]
    costs = list(each(cost, jobs, core_count(), LIMIT, _failed))
    return [
        *(_over(title, cases, costs) for title, cases in TABLES.items()),
        _over_catalogue(costs),
        *(alone(_of_measured) if MEASURED.exists() else []),
    ]


def cost(job: tuple[Case, int]) -> Cost:
    """Identify one case."""
    case, seed = job
    _identified(replace(BASE, trials=1, duration=4.0), 0)  # compiled code is loaded before anything is timed
    return _identified(case, seed)


def _identified(case: Case, seed: int) -> Cost:
    trials = case.measured(seed)
    begin = time.process_time()
    found = identify(trials, [], IdentifyOptions(named_effects_only=case.named_only))
    identified = time.process_time()
    trace(found)
    return Cost(case, identified - begin, time.process_time() - identified)


def _failed(job: tuple[Case, int], why: str) -> Cost:
    return Cost(job[0], failure=why)


def _over(title: str, cases: Mapping[str, Case], costs: Sequence[Cost]) -> Table:
    rows = []
    for name, case in cases.items():
        samples = case.trials * round(case.duration * case.rate)
        clean, hiding = case, replace(case, hidden=1)
        rows.append(
            (
                name,
                whole(samples),
                _median(costs, clean, "identify"),
                _median(costs, clean, "trace"),
                _median(costs, hiding, "trace"),
            )
        )
    columns = ("", "samples", "paper's model [s]", "effects, nothing hidden [s]", "effects, dry friction hidden [s]")
    return Table(title, columns, rows)


def _over_catalogue(costs: Sequence[Cost]) -> Table:
    named = len(CATALOGUE) - len(CURVES)
    looked_for = {
        f"{named} named effects": True,
        f"{named} named effects and {len(CURVES)} nonparametric torques": False,
    }
    rows = [
        (
            name,
            *(_median(costs, replace(BASE, hidden=hidden, named_only=only), "trace") for hidden in (0, 1, 2)),
        )
        for name, only in looked_for.items()
    ]
    columns = ("looked for", "nothing hidden [s]", "dry friction [s]", "dry friction, a spring [s]")
    return Table("Over the catalogue, two trials of 10 s at 200 Hz", columns, rows)


def _median(costs: Sequence[Cost], case: Case, part: str) -> str:
    of_case = [one for one in costs if one.case == case]
    done = [getattr(one, part) for one in of_case if not one.failure]
    return number(statistics.median(done)) if done else of_case[0].failure


def _of_measured() -> list[Table]:
    """Return the table of another lab's swing, which is not a part of this project."""
    clock, theta1, theta2 = np.loadtxt(MEASURED, delimiter=",", skiprows=1, usecols=(0, 1, 2))[::5].T
    trial = Trial("measured", clock - clock[0], np.column_stack([theta1, theta2]))
    begin = time.process_time()
    found = identify([trial], [], MEASURED_RIG)
    seconds = time.process_time() - begin
    return [
        Table(
            "A measured swing",
            ("", "windows", "error [mrad]", "CPU time [s]"),
            [(f"{trial.duration:.0f} s at 200 Hz, the paper's model", str(len(found.fit.windows)),
              number(1e3 * found.fit.rmse(), 3), number(seconds))],
            "Where its file is there: it is not a part of this project.",
        )
    ]  # fmt: skip
