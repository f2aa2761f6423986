# Copyright 2026 cdp_ident maintainers
# SPDX-License-Identifier: Apache-2.0
"""What a report is made of: the bags, how they were identified, and the result."""

from collections.abc import Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from cdp_ident.configuration.settings import Settings
from cdp_ident.diagnosis.identification import Identification
from cdp_ident.tracing.select_effects import ExpectedEffect
from cdp_ident.tracing.trace import Trace
from cdp_ident.trial.trial import Trial


@dataclass(frozen=True)
class Job:
    """Bags, and what is to be done with them."""

    bags: tuple[Path, ...]
    """Bags to fit jointly."""
    holdout: tuple[Path, ...]
    """Bags to hold out; if there is none, parts of the others are held out."""
    settings: Settings
    expected: tuple[ExpectedEffect, ...] = ()
    """Effects found on the rig before."""
    own_effects: Mapping[str, Any] = field(default_factory=dict)
    """Definitions of the user's own effects, which are looked for beside the catalogue's."""


@dataclass(frozen=True)
class LoadedJob:
    """A job whose bags are read."""

    job: Job
    fit: tuple[Trial, ...]
    holdout: tuple[Trial, ...]
    checksums: Mapping[Path, Mapping[str, str]]
    """SHA-256 of each bag's files."""

    @property
    def trials(self) -> tuple[Trial, ...]:
        """All of them as they were loaded, before any were averaged."""
        return *self.fit, *self.holdout


@dataclass(frozen=True)
class Outcome:
    """A finished job."""

    loaded: LoadedJob
    identification: Identification
    trace: Trace
    search_seconds: float
    """Until the last generation of the last search [s]."""
    seconds: float
    """All in all, the reading of the bags not counted [s]."""
