"""What `report.json` says of a fitted model: its values, and its errors."""

import numpy as np
import numpy.typing as npt

from cdp_ident.diagnosis.evaluation import Errors, ErrorsByRole
from cdp_ident.diagnosis.identifiability import is_determined
from cdp_ident.diagnosis.identification import Identification
from cdp_ident.fit.data import Data
from cdp_ident.fit.motion_model import MotionModel
from cdp_ident.fit.windows import Window
from cdp_ident.model.parameters import CONSTANTS, GROUPS, INERTIA, PARAMETERS
from cdp_ident.report.schema import Section

Array = npt.NDArray[np.float64]


def fit_section(found: Identification, errors: ErrorsByRole) -> Section:
    """Return what a fitted model is: physical values, base parameters and errors."""
    model, values, physical, inertia = found.fit.model, found.fit.values, found.physical, found.inertia
    std = np.sqrt(np.diag(found.covariance))
    numbers = zip(PARAMETERS, physical.values, physical.std, physical.determined, strict=True)
    section = {
        parameter.symbol: _quantity(value, deviation, parameter.unit, sure)
        for parameter, value, deviation, sure in numbers
    }
    for constant, value in zip(CONSTANTS, model.constants(values), strict=True):
        fitted = constant.symbol in model.names
        deviation = std[model.names.index(constant.symbol)] if fitted else 0.0
        section[constant.symbol] = _quantity(value, deviation, constant.unit, is_determined(value, deviation))
    determined = inertia.shown and is_determined(inertia.value, inertia.std)
    section[INERTIA.symbol] = _quantity(inertia.value, inertia.std, INERTIA.unit, determined)
    return {
        "physical": section,
        "physical_possible": physical.possible,
        "outer_rod_length_m": model.mechanism.outer_length,
        "groups": {
            group.symbol: _quantity(value, deviation, group.unit, is_determined(value, deviation))
            for group, value, deviation in zip(GROUPS, values, std, strict=False)
        },
        "weight_errors": _weight_errors(model, values, std),
        "correlation": _correlation(model, found.covariance),
        "error": errors_section(found.data, errors),
    }


def _weight_errors(model: MotionModel, values: Array, std: Array) -> list[Section]:
    estimates = zip(model.weight_errors, values[model.of_weights], std[model.of_weights], strict=True)
    return [
        {"of": of, "rod": rod, "given": given, "value": value, "std": deviation}
        for (of, rod, given), value, deviation in estimates
    ]


def _correlation(model: MotionModel, covariance: Array) -> Section:
    """Return how the errors of the estimates go together; not a number for one that the trials do not show.

    The coefficients of curves are not among them.
    """
    shown = ~model.of_curves
    covariance = covariance[np.ix_(shown, shown)]
    std = np.sqrt(np.diag(covariance))
    with np.errstate(divide="ignore", invalid="ignore"):
        matrix = covariance / np.outer(std, std)
    return {"names": [name for name, is_shown in zip(model.names, shown, strict=True) if is_shown], "matrix": matrix}


def _quantity(value: float, std: float, unit: str, determined: bool) -> Section:
    return {"value": value, "std": std, "unit": unit, "determined": determined}


def errors_section(data: Data, errors: ErrorsByRole) -> Section:
    """Return the errors of a model over the motion of each role."""
    return {"fit": _error(errors.fit, data.fit), "holdout": _error(errors.holdout, data.holdout)}


def _error(errors: Errors, windows: tuple[Window, ...]) -> Section:
    return {
        "rmse_rad": errors.rmse,
        "rmse_theta1_rad": errors.rmse_theta1,
        "rmse_theta2_rad": errors.rmse_theta2,
        "window_s": round(float(np.mean([window.duration for window in windows])), 3),
        "sse_free_run": errors.free_run,
        "fit_theta1_percent": errors.fit_theta1,
        "fit_theta2_percent": errors.fit_theta2,
    }
