"""Every picture of a report, in the order in which it shows them."""

from cdp_ident.report.curves import Curves
from cdp_ident.report.figures.description import Figure
from cdp_ident.report.figures.errors import before_and_after, best_error, candidates, selection
from cdp_ident.report.figures.motion import angles, continuous_runs
from cdp_ident.report.figures.next_trial import next_trial
from cdp_ident.report.figures.parameters import against_nominal, correlation, repeatability
from cdp_ident.report.figures.torques import effects_through_residuals, missing_torques, nonparametric_torques
from cdp_ident.report.figures.validation import prediction, residual_correlation
from cdp_ident.report.schema import Section


def figures(report: Section, curves: Curves) -> list[Figure]:
    """Return the pictures of a report."""
    return [
        before_and_after(report),
        *angles(report, curves),
        *prediction(report),
        residual_correlation(report),
        *best_error(report),
        *continuous_runs(report, curves),
        *selection(report),
        *candidates(report),
        *missing_torques(report, curves),
        *effects_through_residuals(report, curves),
        *nonparametric_torques(report),
        against_nominal(report),
        *correlation(report),
        *repeatability(report),
        *next_trial(report),
    ]
