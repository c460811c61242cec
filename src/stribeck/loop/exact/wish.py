"""What a call of the runtime of rounds is asked for, and the turns that it gives, as declared in ``rounds.h``."""

from __future__ import annotations

import ctypes

import numpy as np

from stribeck.mirrored import check_structure

_REALS = ("rtol", "atol", "bound", "quiet", "quiet_slide", "sample", "end", "record_step")
_WHOLES = ("watch", "most", "first", "count", "rows", "size", "calm")

TURN = np.dtype([(name, float) for name in ("time", "deviation", "low", "high", "speed", "stuck", "joint")])


class Wish(ctypes.Structure):
    """What a call is asked for."""

    _fields_ = [*[(name, ctypes.c_double) for name in _REALS], *[(name, ctypes.c_longlong) for name in _WHOLES]]


def check_rounds(library: ctypes.CDLL) -> None:
    """Raise `StribeckError` where a library's structures are not those of this module."""
    check_structure(library, "sb_wish", Wish)
    check_structure(library, "sb_turn", TURN)
