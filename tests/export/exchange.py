"""A Model Exchange importer with located events: scipy's DOP853 between them, the command held between samples."""

import numpy as np
from scipy.integrate import solve_ivp

from .driver import Instance


def exchanged(me: Instance, times: np.ndarray, command: np.ndarray, *, rtol: float = 1e-10) -> tuple[np.ndarray, int]:
    """Return outputs q, dq, sliding (M, 3 n) at the samples, after each one's event, and how many events were met."""
    n, events, rows = command.shape[1], 0, []
    names = [f"{key}[{j + 1}]" for key in ("q", "dq", "sliding") for j in range(n)]
    y = me.y()

    def rate(t: float, state: np.ndarray) -> np.ndarray:
        me.at(t, state)
        return me.rates()

    watches = [_watch(me, i) for i in range(me.fmu.indicators)]
    for k, t in enumerate(times):
        assert me.call("EnterEventMode") == 0
        me.put({f"tau[{j + 1}]": command[k, j] for j in range(n)})
        if me.update():
            y = me.y()
        assert me.call("EnterContinuousTimeMode") == 0
        rows.append(me.get(*names))
        end = times[k + 1] if k + 1 < len(times) else t
        while t < end:
            found = solve_ivp(rate, (t, end), y, "DOP853", events=watches, rtol=rtol, atol=1e-2 * rtol)
            assert found.status >= 0, found.message
            t, y = float(found.t[-1]), found.y[:, -1].copy()
            me.at(t, y)
            if found.status == 1:
                events += 1
                me.event()
                y = me.y()
    return np.array(rows), events


def _watch(me: Instance, i: int):
    def watch(t: float, state: np.ndarray) -> float:
        me.at(t, state)
        return me.edges()[i]

    watch.terminal, watch.direction = True, -1.0  # type: ignore[attr-defined]
    return watch


def euler(me: Instance, end: float, h: float, command: np.ndarray) -> np.ndarray:
    """Return q and sliding (steps + 1, 2 n) of an importer with a fixed Euler step under a constant command."""
    n = len(command)
    names = [f"{key}[{j + 1}]" for key in ("q", "sliding") for j in range(n)]
    me.put({f"tau[{j + 1}]": command[j] for j in range(n)})
    me.event()
    y, before = me.y(), me.edges()
    rows = [me.get(*names)]
    for k in range(round(end / h)):
        y = y + h * me.rates()
        me.at((k + 1) * h, y)
        after = me.edges()
        if np.any((before < 0.0) != (after < 0.0)):
            me.event()
            y, after = me.y(), me.edges()
        before = after
        rows.append(me.get(*names))
    return np.array(rows)
