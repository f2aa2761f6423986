# Copyright 2026 cdp_ident maintainers
# SPDX-License-Identifier: Apache-2.0
"""Reads `report.json`, and checks it against its schema: it may come from anyone."""

import json
from pathlib import Path
from typing import NoReturn

from cdp_ident.errors import ReportError
from cdp_ident.files import read_regular
from cdp_ident.model.effects import own
from cdp_ident.model.effects.catalogue import known_effects
from cdp_ident.model.parameters import INERTIA
from cdp_ident.outside_text import shown
from cdp_ident.report.schema import REPORT, SCHEMA, Section, filled, problem
from cdp_ident.user_input import refuse_unknown

_LARGEST = 1 << 24
"""Bytes; identify writes some 30 000, and 20 for each generation of a search."""


def read_report(path: Path) -> Section:
    """Read a `report.json`; its texts are fit to be shown, and numbers that are null infinite.

    Raises:
        ReportError: the file is not there, is no JSON, is of another schema, or contradicts it.
        OptionError: it has an effect that is not known, or an own one whose definition is wrong.
    """
    try:
        content = json.loads(read_regular(path, _LARGEST).decode(), parse_constant=_refuse)
    except FileNotFoundError as error:
        raise ReportError(f"there is no {path}: give the folder that identify wrote its report into") from error
    except (OSError, ValueError, RecursionError) as error:
        reason = getattr(error, "strerror", None) or shown(error, 200)
        raise ReportError(f"{path} cannot be read: {reason}") from error
    schema = content.get("schema") if isinstance(content, dict) else None
    if schema != SCHEMA:
        is_of = shown(repr(schema), 60)
        raise ReportError(f"{path} is of the schema {is_of}, not {SCHEMA!r}: identify again with this version")
    if wrong := problem(content):
        raise ReportError(f"{path}: {wrong}; was it changed, or written by another version? identify again")
    report: Section = filled(REPORT, content)
    own.use(content["own_effects"], report["after"]["physical"][INERTIA.symbol]["value"], str(path))
    named = (effect["name"] for effect in (*report["effects"], *report["expected"]))
    refuse_unknown(named, {effect.name for effect in known_effects()}, f"effect in {path}")
    return report


def _refuse(constant: str) -> NoReturn:
    raise ValueError(f"{constant} is no number in JSON")
