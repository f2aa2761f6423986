# Copyright 2026 cdp_ident maintainers
# SPDX-License-Identifier: Apache-2.0
"""The errors that this package raises on purpose.

A message says what was wrong, where (file, topic, joint, time), what was expected, and what to do about it.
"""


class CdpIdentError(Exception):
    """Root of every error that a user can cause and mend; commands print it as one line and exit with its code."""

    exit_code = 2


class OptionError(CdpIdentError):
    """An option, a parameter or a configuration file does not say something usable."""


class NoSectionError(OptionError):
    """A parameter file has nothing for this node: it may be meant for others."""


class BagError(CdpIdentError):
    """A bag or a file to be made into one cannot be read or written."""


class TrialError(CdpIdentError):
    """A bag is readable, but what it holds is not a trial that parameters can be identified from."""


class NoFreeMotionError(TrialError):
    """A recording holds no zero-input motion that is long enough."""


class OtherMotionError(TrialError):
    """The motion is not that of a free double pendulum, whatever its columns mean."""


class IdentificationError(CdpIdentError):
    """The trials are good, but the search or the fit cannot work with them."""


class FitFailedError(IdentificationError):
    """The model's best motion is not the measured one: nothing that was fitted means anything."""

    exit_code = 3


class SimulationError(CdpIdentError):
    """The model's motion cannot be computed."""


class RigError(CdpIdentError):
    """The rig's serial port or what comes through it is not usable."""


class ReportError(CdpIdentError):
    """A folder does not hold a report that can be read, or what it holds cannot be drawn."""
