"""Reads `report.json`, and checks that it holds what tables, pictures and comparisons take from it."""

import json
import math
from collections.abc import Iterator
from pathlib import Path
from typing import Any, get_args

from cdp_ident.errors import ReportError
from cdp_ident.model.effects.effect import Joint
from cdp_ident.model.parameters import GROUPS, NOMINAL
from cdp_ident.report.contents import SCHEMA, Section
from cdp_ident.tracing.selection import Certainty

_LARGEST = 2**27
"""Bytes; a longer file was not written by identify."""


class _Optional:
    """A value that may be null."""

    def __init__(self, kind: Any) -> None:
        self.kind = kind


class _Each:
    """An object with any keys, all of whose values are alike."""

    def __init__(self, kind: Any) -> None:
        self.kind = kind


class _Choice:
    """One of a few words."""

    def __init__(self, *words: str) -> None:
        self.words = words


_NUMBER = _Optional(float)  # null stands for what is not finite
_ESTIMATE = {"value": _NUMBER, "std": _NUMBER}
_QUANTITY = {"value": _NUMBER, "std": _NUMBER, "unit": str, "determined": bool}
_ERROR = {
    "rmse_rad": _NUMBER, "rmse_theta1_rad": _NUMBER, "rmse_theta2_rad": _NUMBER, "window_s": float,
    "sse_free_run": _NUMBER,
}  # fmt: skip
_ERRORS = {"fit": _ERROR, "holdout": _ERROR}
_FIT = {
    "physical": dict.fromkeys(NOMINAL, _QUANTITY),
    "groups": {group.symbol: _QUANTITY for group in GROUPS},
    "error": _ERRORS,
    "correlation": {"names": [str], "matrix": [[_NUMBER]]},
}
_SHAPE = {
    "trials": [
        {
            "bag": str, "name": str, "role": _Choice("fit", "holdout"), "samples": float, "start_s": float,
            "duration_s": float, "warnings": [str],
        }
    ],
    "noise_rad": {"theta1": float, "theta2": float},
    "search": {
        "method": str, "cut_short": bool, "seed": float, "population": float, "generations": float,
        "searches": float, "evaluations": float, "sse": _NUMBER, "seconds": float, "history": [_NUMBER],
        "stopped": str,
    },
    "stages": dict.fromkeys(("nominal", "search", "refined"), _ERRORS),
    "before": _FIT,
    "effects": [
        {
            "name": str, "joint": _Choice(*get_args(Joint)), "variant": str, "trial": _Optional(str),
            "description": str, "formula": str, "source": str,
            "parameters": _Each({"value": _NUMBER, "std": _NUMBER, "unit": str, "as_fitted": _ESTIMATE}),
            "evidence": {"rmse_holdout_before_rad": _NUMBER, "rmse_holdout_after_rad": _NUMBER, "delta_bic": _NUMBER},
            "curve": _Optional(
                {
                    "over": _Choice("angle", "speed"), "at": [float], "torque": [_NUMBER], "std": [_NUMBER],
                    "coefficients": [float], "coefficients_std": [_NUMBER], "likeness": str,
                }
            ),
            "certainty": _Choice(*get_args(Certainty)),
            "also_possible": [str],
        }
    ],
    "after": _FIT,
    "unexplained": {"significant": bool, "joint": str, "times_noise": _NUMBER, "description": str},
    "verdict": str,
    "ladder": {
        "interrupted": bool,
        "rungs": [
            {
                "action": str, "rmse_fit_rad": _NUMBER, "rmse_holdout_rad": _NUMBER,
                "tried": [
                    {"effects": [str], "rmse_fit_rad": _NUMBER, "rmse_holdout_rad": _NUMBER, "delta_bic": _NUMBER}
                ],
            }
        ],
    },
    "repeatability": _Optional(
        {
            "agree": bool, "p_value": float,
            "trials": [
                {"trial": str, "groups": {group.symbol: _ESTIMATE for group in GROUPS}}
            ],
        }
    ),
    "identifiability": {"words": [str]},
    "warnings": [{"name": str, "message": str}],
    "run": {
        "written_at": str, "seconds": float, "versions": _Each(str),
        "options": {
            **dict.fromkeys(("L", "g"), float),
            **{f"nominal.{symbol}": float for symbol in NOMINAL if symbol not in ("L", "g")},
        },
        "bag_sha256": _Each(_Each(str)),
    },
}  # fmt: skip


def read_report(path: Path) -> Section:
    """Read a `report.json`.

    Raises:
        ReportError: the file is not there, is no JSON, is of another schema, or lacks something.
    """
    try:
        if path.stat().st_size > _LARGEST:
            raise ReportError(f"{path} is too large to be a report")
        content = json.loads(path.read_text(encoding="utf-8"))
    except FileNotFoundError as error:
        raise ReportError(f"there is no {path}: give the folder that identify wrote its report into") from error
    except (OSError, ValueError, RecursionError) as error:
        raise ReportError(f"{path} cannot be read: {error}") from error
    schema = content.get("schema") if isinstance(content, dict) else None
    if schema != SCHEMA:
        raise ReportError(f"{path} is of the schema {schema!r:.60}, not {SCHEMA!r}: identify again with this version")
    for problem in _problems(content, _SHAPE, ""):
        raise ReportError(f"{path}: {problem}; was it changed, or written by another version? identify again")
    return dict(content)


def _problems(content: Any, shape: Any, place: str) -> Iterator[str]:
    if isinstance(shape, _Optional):
        if content is not None:
            yield from _problems(content, shape.kind, place)
    elif isinstance(shape, _Choice):
        if content not in shape.words:
            yield f"{place} should be one of {', '.join(shape.words)}"
    elif isinstance(shape, _Each):
        if not isinstance(content, dict):
            yield f"{place} should be an object"
            return
        for key, value in content.items():
            yield from _problems(value, shape.kind, f"{place}.{key:.60}")
    elif isinstance(shape, dict):
        if not isinstance(content, dict):
            yield f"{place} should be an object"
            return
        for key, kind in shape.items():
            inside = f"{place}.{key}" if place else key
            if key not in content:
                yield f"{inside} is missing"
            else:
                yield from _problems(content[key], kind, inside)
    elif isinstance(shape, list):
        if not isinstance(content, list):
            yield f"{place} should be a list"
            return
        for index, value in enumerate(content):
            yield from _problems(value, shape[0], f"{place}[{index}]")
    elif shape is float:
        if isinstance(content, bool) or not isinstance(content, int | float) or not math.isfinite(content):
            yield f"{place} should be a finite number"
    elif not isinstance(content, shape):
        yield f"{place} should be {'text' if shape is str else 'true or false'}"
