"""What an encoder that is off at the last joint cannot be told from: a centre of mass beside its link's line.

Files made from drawings put every centre of mass on the line. A tolerance is a part of a value, and a part of zero is
zero: what lies beside the line then shows as a link that seems turned, exactly as an encoder offset does.
"""

from __future__ import annotations

import math
from collections.abc import Sequence

from stribeck.arm import Arm
from stribeck.gap.result import Cause

TURNED = "encoder_offset"


def told_off_the_line(arm: Arm, causes: Sequence[Cause], named: Sequence[str]) -> list[str]:
    """Return a note where a named offset may as well be a centre of mass, and what to state if it is.

    Parameters
    ----------
    arm : Arm
        The nominal arm.
    causes : sequence of Cause
        With their parameters.
    named : sequence of str
        Effects that the diagnosis names.
    """
    last = arm.joints[-1]
    told = []
    for cause in causes:
        if cause.effect != TURNED or TURNED not in named or last.name not in cause.joints or cause.anywhere:
            continue
        if last.com[1] != 0.0 or "com_y" in last.tolerance:
            continue
        beside = -last.com[0] * math.sin(cause.parameters[last.name]["offset"].value)
        told.append(
            f"{TURNED} at {last.name}: no motion can tell it from a centre of mass {1e3 * beside:.2g} mm beside the "
            "link's line, where the arm file has 0; if it may lie there, state com_y in [joints.tolerance]"
        )
    return told
