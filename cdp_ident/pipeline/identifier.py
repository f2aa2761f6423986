# Copyright 2026 cdp_ident maintainers
# SPDX-License-Identifier: Apache-2.0
"""One identification from the command line's request to the files of its report, without ROS."""

from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

from rich.console import Console

from cdp_ident.bag.folders import WatchedFolder
from cdp_ident.configuration.fitted_model import fitted_yaml
from cdp_ident.configuration.parameter_file import read_parameter_file
from cdp_ident.configuration.settings import Settings, is_key, without_results
from cdp_ident.diagnosis.new_trial import NewTrialCheck, check_new_trial
from cdp_ident.errors import CdpIdentError, FitFailedError, OptionError
from cdp_ident.model.effects import own
from cdp_ident.model.effects.catalogue import forget_own
from cdp_ident.output_folder import check_folder, json_text
from cdp_ident.outside_text import shown
from cdp_ident.pipeline.interruption import GivenUpError, Interruption
from cdp_ident.pipeline.job import load, load_with_weights, refuse_copies, run
from cdp_ident.pipeline.progress import SearchDisplay
from cdp_ident.report.chapters import document_of
from cdp_ident.report.contents import report
from cdp_ident.report.curves import Curves, curves, curves_npz
from cdp_ident.report.document import print_document
from cdp_ident.report.folder import CURVES, FIGURES, FILES, FITTED, PAGE, REPORT, TEXT, State, state_of, write_result
from cdp_ident.report.knowledge import expected_effects
from cdp_ident.report.outcome import Job, LoadedJob, Outcome
from cdp_ident.report.pictures import draw
from cdp_ident.report.report_file import read_report
from cdp_ident.report.schema import Section
from cdp_ident.search.genetic_search import Progress
from cdp_ident.trial.trial import Trial
from cdp_ident.user_input import user_path

NODE_NAME = "identify"
BAGS = "bags"
"""The node's parameter that names the bags, which is no setting."""
DEFAULT_FOLDER = Path("identification")
_LONGEST_SENTENCE = 2000


@dataclass(frozen=True)
class Result:
    """What an identification found."""

    report: Section
    """The contents of `report.json`."""
    curves: Curves
    failure: str = ""
    """Why no parameter means anything, in words."""


@dataclass(frozen=True)
class Request:
    """What the command line asks for."""

    bags: Sequence[Path]
    holdout: Sequence[Path]
    out: Path | None
    method: str | None
    seed: int | None
    config: Path | None
    force: bool
    watch: Path | None = None
    """Folder whose bags are fitted too, as they come."""
    figures: bool = False
    """Whether figures are drawn as files, too."""
    like: Path | None = None
    """Folder of an earlier report of the rig, whose effects are expected."""
    effects_file: str | None = None
    """YAML file of the user's own effects."""


def read_configuration(config: Path | None) -> dict[str, Any]:
    """Return the parameters that a ROS parameter file has for identify; none where no file is given.

    Raises `OptionError` where it cannot be read, or has nothing for identify.
    """
    return read_parameter_file(config, NODE_NAME).taken(is_key) if config else {}


class Identifier:
    """Identifies what was requested, as often as asked, into the same folder."""

    def __init__(self, request: Request, output: Console, progress: Console) -> None:
        self.request, self._output, self._progress = request, output, progress
        self.warn: Callable[[str], None] = lambda sentence: None
        """Is given what is to be warned of beside the report, which is printed as well."""
        self._folder = request.out
        self._written: set[Path] = set()
        """Folders whose reports are its own."""
        self._seen: State = None
        """The report in its folder that this one may take the place of."""
        self._display: SearchDisplay | None = None
        self._watched = WatchedFolder(request.watch) if request.watch else None
        self._came: list[Path] = []
        """Bags of the watched folder that are fitted too."""
        self._latest: Outcome | None = None
        self._new_trials: list[NewTrialCheck] = []

    def settings(self, given: Mapping[str, Any]) -> Settings:
        """Read the configuration; `given` are the parameters from ROS.

        Raises `CdpIdentError` for whatever is wrong with it.
        """
        request = self.request
        values, passed_over = without_results({**read_configuration(request.config), **given})
        values.pop(BAGS, None)
        if passed_over:
            self._say(passed_over)
        values |= {
            name: value for name in ("method", "seed", "effects_file") if (value := getattr(request, name)) is not None
        }
        return Settings.of(values)

    def take_bags(self, bags: Sequence[Path]) -> None:
        """Identify from other bags the next time, into a folder of the first one's name unless one was asked for."""
        self.request, self._folder = replace(self.request, bags=bags), self.request.out

    @property
    def waits_for(self) -> Path | None:
        """The folder whose bags are waited for, where no bag is given."""
        return None if self.request.bags else self.request.watch

    @property
    def doing(self) -> str:
        """What the search that runs does, in words; empty where none runs."""
        return self._display.doing if self._display else ""

    @property
    def has_new(self) -> bool:
        """Whether a bag has come into the watched folder that was not there at the last identification."""
        return self._watched is not None and bool(self._watched.new())

    def load(self, given: Mapping[str, Any]) -> LoadedJob:
        """Read the configuration and the bags; `given` are the parameters from ROS.

        Raises `CdpIdentError` for whatever is wrong with them, and for a folder that holds a report already.
        """
        settings = self.settings(given)
        if self._watched:
            self._update_bags(self._watched, settings)
        forget_own()
        earlier = read_report(self.request.like / REPORT) if self.request.like else None
        own_effects = dict(earlier["own_effects"]) if earlier else {}
        if file := settings.identify.effects_file:
            own_effects |= own.read_own_effects(user_path(file))
        own.use(own_effects, settings.identify.model.mechanism.inertia, file or "--like")
        expected = expected_effects(earlier) if earlier else ()
        job = Job((*self.request.bags, *self._came), tuple(self.request.holdout), settings, expected, own_effects)
        loaded = load(job, more_to_come=self._watched is not None)
        name = self.request.watch.resolve().name if self.request.watch else loaded.fit[0].name
        self._folder = self._folder or DEFAULT_FOLDER / name
        check_folder(self._folder, self.request.force or self._folder in self._written, FILES)
        self._seen = state_of(self._folder)
        return loaded

    def _update_bags(self, watched: WatchedFolder, settings: Settings) -> None:
        """Leave out bags of the watched folder that are gone, and add the new ones, each checked by the model first.

        One that has no trial, or is the copy of another, is left out until its files change.
        """
        for bag in self._came:
            if not bag.exists():
                self._warn(f"{bag} is left out from now on: it is not there any more")
        self._came = [bag for bag in self._came if bag.exists()]
        for bag in watched.new():
            watched.take(bag)
            again = bag in self._came
            others = [other for other in self._came if other != bag]
            try:
                trial = load_with_weights(bag, settings)
                refuse_copies([*self.request.bags, *others, bag, *self.request.holdout])
                if self._latest and not again:
                    self._check_new_trial(self._latest, trial)
            except CdpIdentError as error:
                self._warn(f"{bag} is left out: {error}")
                self._came = others
            else:
                self._came = [*others, bag]

    def _check_new_trial(self, latest: Outcome, trial: Trial) -> None:
        fit = latest.trace.completed.fit
        errors = {error for weight in trial.weights for error in weight.errors}
        if trial.weights and not (fit.model.inertia_free and errors <= {*fit.model.weight_errors}):
            self._say(f"{trial.name} is not checked: it is the first one with its weight")
            return
        expected = latest.trace.errors["effects"].holdout.rmse
        check = check_new_trial(fit, latest.trace.covariance, expected, trial, latest.identification.data)
        self._new_trials.append(check)
        if check.fits:
            self._say(check.words)
        else:
            self._warn(check.words)

    def _warn(self, sentence: str) -> None:
        self._say(sentence)
        self.warn(shown(sentence, _LONGEST_SENTENCE))

    def _say(self, sentence: str) -> None:
        self._output.print(shown(sentence, _LONGEST_SENTENCE), highlight=False, markup=False, soft_wrap=True)

    def identify(self, loaded: LoadedJob, interruption: Interruption) -> Result:
        """Identify, print the report, and return it; `write` writes it.

        An interruption ends the search, not the identification. Raises `CdpIdentError`, and `GivenUpError` where the
        identification was given up.
        """
        with SearchDisplay(self._progress, loaded.job.settings.identify.search.generations) as display:

            def stop(progress: Progress) -> str | None:
                if interruption.given_up:
                    raise GivenUpError
                display.show(progress)
                if not interruption.asked:
                    return None
                display.say("the search ends here; its best so far is refined (Ctrl-C again ends at once)")
                return "interrupted"

            def ends() -> bool:
                return interruption.asked or interruption.given_up

            self._display = display
            with interruption.searching():
                outcome = run(loaded, stop, display.say, ends, display.trying)
        if interruption.given_up:
            raise GivenUpError
        if not outcome.trace.failure:
            self._latest = outcome
        result = Result(report(outcome, self._new_trials, ends), curves(outcome), outcome.trace.failure)
        with self._going_on_without("the report cannot be printed"):
            print_document(self._output, document_of(result.report))
        return result

    def write(self, result: Result) -> None:
        """Write the files of a result, its numbers before its pictures.

        Raises `OptionError` where the numbers cannot be written; `fitted.yaml` is printed then, that they are not lost.
        Of a fit that failed there is no `fitted.yaml`; `FitFailedError` is raised when the report is written.
        """
        files: dict[str, str | bytes] = {REPORT: json_text(result.report), CURVES: curves_npz(result.curves)}
        if not result.failure:
            files[FITTED] = fitted_yaml(result.report)
        try:
            folder = self._write_numbers(files)
        except OptionError:
            if not result.failure:
                self._say(f"{FITTED}, which could not be written:")
                self._output.print(files[FITTED], highlight=False, markup=False, soft_wrap=True)
            raise
        if not result.failure:
            self._say(f"{folder / REPORT} and {FITTED} are written")
        self._draw(folder)
        if result.failure:
            raise FitFailedError(f"{result.failure}; {folder / REPORT} tells more")

    def _write_numbers(self, files: Mapping[str, str | bytes]) -> Path:
        assert self._folder is not None
        folder = write_result(self._folder, files, self._seen)
        if folder != self._folder:
            self._warn(f"another identify has written into {self._folder} meanwhile: this one goes into {folder}")
        self._folder, self._seen = folder, state_of(folder)
        self._written.add(folder)
        return folder

    def _draw(self, folder: Path) -> None:
        with self._going_on_without(f"no pictures, until `ros2 run cdp_ident report {folder}` can draw them"):
            draw(folder, self.request.figures)
            drawn_too = f"{folder / TEXT} and {FIGURES}/ are" if self.request.figures else f"{folder / TEXT} is"
            self._say(f"{folder / PAGE} shows it all; {drawn_too} for version control and papers")

    @contextmanager
    def _going_on_without(self, what: str) -> Iterator[None]:
        """Say what is missing where it fails, and why; whatever that is, the result is to be served and written."""
        try:
            yield
        except Exception as error:  # noqa: BLE001
            self._say(f"{what}: {shown(error) or type(error).__name__}")
