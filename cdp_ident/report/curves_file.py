# Copyright 2026 cdp_ident maintainers
# SPDX-License-Identifier: Apache-2.0
"""`curves.npz`: the curves of a report as plain arrays, from which its pictures are made anew."""

import io
import zipfile
from dataclasses import fields
from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt

from cdp_ident.errors import ReportError
from cdp_ident.model.parameters import LARGEST
from cdp_ident.outside_text import shown
from cdp_ident.regular_file import read_regular
from cdp_ident.report.curves import Curves, TorqueCurves, TrialCurves

FORMAT = "cdp_ident/curves/1"
_LARGEST = 2**29
"""Bytes of all arrays together, and of the file: an hour at 1 kHz; one that unfolds to more is none of ours."""

_TAIL: dict[str, tuple[int, ...]] = dict.fromkeys(
    ("measured", "before", "after", "run_before", "run_after", "angle", "speed", "missing", "std", "effects"), (2,)
)
"""Shape of a sample, where it is more than one number."""
_TYPES: dict[str, type] = {"window": np.int64, "trial": np.int64, "held_out": np.bool_}
"""Types of what is not a number."""


def curves_npz(curves: Curves) -> bytes:
    """Return the contents of `curves.npz`."""
    parts: dict[str, TrialCurves | TorqueCurves] = {f"trial{i}": trial for i, trial in enumerate(curves.trials)}
    parts |= {"torques_before": curves.before, "torques_after": curves.after}
    arrays = {
        f"{part}.{field.name}": getattr(content, field.name)
        for part, content in parts.items()
        for field in fields(content)
    }
    stream = io.BytesIO()
    np.savez_compressed(stream, format=np.array(FORMAT), **arrays)
    return stream.getvalue()


def read_curves(path: Path, trials: int, effects: int) -> Curves:
    """Read `curves.npz` of a report with so many trials and effects.

    Raises:
        ReportError: the file is not there, is damaged, or does not hold these curves.
    """
    if not path.exists():
        raise ReportError(f"there is no {path}: identify writes it beside report.json; identify again")
    try:
        packed = io.BytesIO(read_regular(path, _LARGEST))
        with zipfile.ZipFile(packed) as archive:
            size = sum(member.file_size for member in archive.infolist())
        with np.load(packed, allow_pickle=False) as content:
            arrays = {name: content[name] for name in content.files if size <= _LARGEST}
    except Exception as error:  # what a damaged archive brings zipfile, zlib and numpy to raise has no end
        raise ReportError(f"{path} cannot be read ({shown(error)}): identify again") from error
    if size > _LARGEST:
        raise ReportError(f"{path} would unfold to {size} bytes: it was not written by identify")
    if str(arrays.get("format")) != FORMAT:
        raise ReportError(f"{path} is not of the format {FORMAT}: identify again with this version")
    return Curves(
        tuple(TrialCurves(**_part(TrialCurves, path, f"trial{index}", arrays)) for index in range(trials)),
        TorqueCurves(**_part(TorqueCurves, path, "torques_before", arrays)),
        TorqueCurves(**_part(TorqueCurves, path, "torques_after", arrays, effects)),
    )


def _part(
    kind: type[TrialCurves | TorqueCurves], path: Path, part: str, arrays: dict[str, npt.NDArray[Any]], effects: int = 0
) -> dict[str, npt.NDArray[Any]]:
    """Return the arrays of one part of the curves by their fields, each of the type and shape that it must have.

    What is infinite, or larger than anything measured, is not a number there: it is not drawn.
    """
    found: dict[str, npt.NDArray[Any]] = {}
    samples = int(arrays.get(f"{part}.time", np.empty(0)).size)
    for field in fields(kind):
        name, dtype = f"{part}.{field.name}", np.dtype(_TYPES.get(field.name, np.float64))
        shape = (*((effects,) if field.name == "effects" else ()), samples, *_TAIL.get(field.name, ()))
        array = arrays.get(name)
        if array is None or array.shape != shape or array.dtype != dtype or (kind is TrialCurves and not samples):
            is_now = "missing" if array is None else f"{array.dtype} of shape {array.shape}"
            raise ReportError(
                f"{path} does not fit its report.json: {name} is {is_now}, not {dtype} of shape {shape}: identify again"
            )
        found[field.name] = array if array.dtype.kind != "f" else np.where(np.abs(array) <= LARGEST, array, np.nan)
    if np.any(np.isnan(found["time"])):
        raise ReportError(f"{path} does not hold usable curves: {part}.time has no time in it; identify again")
    return found
