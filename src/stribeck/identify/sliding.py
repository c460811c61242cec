"""Where a joint surely slides: at rest the noise of its encoder looks like motion to and fro.

Laws in the distance slid count both ways. Of noise they would see no end: a bristle at rest would give way, and what
has aged would be new again. A hysteresis of the width of the noise (the play operator, Krasnosel'skii & Pokrovskii
1989) lets net motion pass, and nothing else.
"""

from __future__ import annotations

import numpy as np

REACH = 2.5  # standard deviations of position, to either side: a hundredth of the noise at rest passes for motion


def sliding(position: np.ndarray, sd: np.ndarray) -> np.ndarray:
    """Return the part (N, n) of the motion about each sample that is surely slid, 0 to 1.

    Parameters
    ----------
    position : array (N, n)
        rad.
    sd : array (n,)
        Its noise, rad.
    """
    through = np.stack([_play(values, REACH * float(s)) for values, s in zip(position.T, sd, strict=True)], axis=1)
    gone, passed = (np.abs(_about(values)) for values in (position, through))
    return np.asarray(np.clip(np.divide(passed, gone, out=np.zeros_like(gone), where=gone > 0.0), 0.0, 1.0))


def _about(values: np.ndarray) -> np.ndarray:
    """Return the change (N, n) from the sample before to the one after."""
    padded = np.concatenate([values[:1], values, values[-1:]])
    return np.asarray(padded[2:] - padded[:-2])


def _play(values: np.ndarray, half: float) -> np.ndarray:
    """Return what (N,) is pushed along by values with a play of ``half`` to either side."""
    at, out = float(values[0]), np.empty(len(values))
    for i, value in enumerate(values.tolist()):
        at = min(max(at, value - half), value + half)
        out[i] = at
    return out
