"""Whether the commands are the torques that the arm file is about: their sign, their unit, this side of the gear."""

from __future__ import annotations

import numpy as np

from stribeck.gap.records.prepare import Prepared
from stribeck.gap.records.regions import analysis_signals
from stribeck.identify.commanded import commands_beside


def told_commands(prepared: Prepared, given: np.ndarray) -> list[str]:
    """Return a warning for each joint whose commands are a multiple of what the arm file's model needs, or against it.

    Parameters
    ----------
    prepared : Prepared
    given : array (M, n)
        Residual of that model on the held-out runs, N m.
    """
    asked = analysis_signals(prepared.held)["command"]
    return commands_beside(asked, asked - given, prepared.arm.names)
