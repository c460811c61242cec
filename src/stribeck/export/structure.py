"""The model structure: on which known variables each unknown depends, from the sparsity of the equations."""

from __future__ import annotations

from dataclasses import dataclass

import casadi as ca
import numpy as np

from stribeck.export.code import start_function
from stribeck.export.variables import Table
from stribeck.model.forward import Forward


@dataclass(frozen=True)
class Unknown:
    """One unknown: the value references of itself and of what it depends on, ascending."""

    vr: int
    dependencies: tuple[int, ...]


@dataclass(frozen=True)
class Structure:
    """The model structure of both versions of the standard; each list in ascending order of value references."""

    outputs: tuple[Unknown, ...]
    derivatives: tuple[Unknown, ...]
    indicators: tuple[Unknown, ...]
    initial: tuple[Unknown, ...]


def structure_of(table: Table) -> Structure:
    """Return the structure of an FMU.

    Notes
    -----
    Between events the modes are constant. In the initial state they depend on whatever decides them: all rates and
    all break-away margins. A delayed command is among what the present depends on, since its delay may be tuned to 0.
    """
    forward, base, n = table.forward, table.base, table.forward.n
    known = [0, *range(base["state"], base["rate"]), *range(base["tau"], base["q"])]
    rates = _depends(forward, forward.rates)
    seen = [_depends(forward, part) for part in forward.outputs(*forward.inputs)[:3]]
    margins = _depends(forward, forward.margins)
    deciding = np.any(np.vstack([rates, margins]), axis=0)
    outputs = [_unknown(base["q"] + i, row, known) for i, row in enumerate(np.vstack(seen))]
    outputs += [_sliding(table, j, deciding, known) for j in range(n)]
    derivatives = [_unknown(base["rate"] + i, row, known) for i, row in enumerate(rates)]
    indicators = [_unknown(base["indicator"] + j, _edge(margins, j, n), known) for j in table.indicators]
    return Structure(tuple(outputs), tuple(derivatives), tuple(indicators), _initial(table, rates, seen, deciding))


def _depends(forward: Forward, results: ca.SX) -> np.ndarray:
    """Return which of (t, y, u) each result depends on, as booleans (results, 1 + size + n)."""
    given = ca.vertcat(forward.time, forward.y, forward.command)
    return _pattern(ca.jacobian_sparsity(results, given))


def _pattern(sparsity: ca.Sparsity) -> np.ndarray:
    dense = np.zeros(sparsity.shape, dtype=bool)
    rows, columns = sparsity.get_triplet()
    dense[rows, columns] = True
    return dense


def _unknown(vr: int, row: np.ndarray, known: list[int]) -> Unknown:
    return Unknown(vr, tuple(sorted(known[i] for i in np.flatnonzero(row))))


def _edge(margins: np.ndarray, joint: int, n: int) -> np.ndarray:
    """Return what an event indicator depends on: the velocity of a sliding joint, both margins of a stuck one."""
    row: np.ndarray = margins[joint] | margins[n + joint]
    row[1 + n + joint] = True
    return row


def _sliding(table: Table, joint: int, deciding: np.ndarray, known: list[int]) -> Unknown:
    row = deciding
    if table.forward.bristles[joint]:
        row = np.zeros_like(deciding)
        row[1 + table.forward.n + joint] = True
    return _unknown(table.base["sliding"] + joint, row, known)


def _initial(table: Table, rates: np.ndarray, seen: list[np.ndarray], deciding: np.ndarray) -> tuple[Unknown, ...]:
    """Chain the dependence on (t, y, u) with that of the initial y on what the importer sets."""
    forward, base, n = table.forward, table.base, table.forward.n
    first = [base["q_start"], base["dq_start"], base["tau"], base["p"]]
    lengths = [n, n, n, len(forward.path.entries)]
    known = [0] + [start + i for start, length in zip(first, lengths, strict=True) for i in range(length)]
    begun = _start_pattern(forward)  # of y, on the known variables
    own = _parameter_pattern(forward)
    rows = np.vstack([*seen, rates])
    direct = np.zeros((len(rows), len(known)), dtype=bool)
    direct[:, 0] = rows[:, 0]
    direct[:, 1 + 2 * n : 1 + 3 * n] = rows[:, 1 + forward.size :]
    direct[:, 1 + 3 * n :] = own
    chained = direct | ((rows[:, 1 : 1 + forward.size].astype(int) @ begun.astype(int)) > 0)
    mode = np.any(chained[2 * n :], axis=0)  # friction and rates: what decides the modes
    mode[0] |= bool(deciding[0])
    chained[2 * n :] |= mode
    found = [_unknown(base["q"] + i, chained[i], known) for i in range(3 * n)]
    found += [_unknown(base["sliding"] + j, mode, known) for j in range(n)]
    found += [_unknown(base["state"] + i, row, known) for i, row in enumerate(begun)]
    found += [_unknown(base["rate"] + i, chained[3 * n + i], known) for i in range(forward.size)]
    return tuple(sorted(found, key=lambda unknown: unknown.vr))


def _start_pattern(forward: Forward) -> np.ndarray:
    start = start_function(forward)
    given = start.sx_in()
    pattern = _pattern(ca.jacobian_sparsity(start(*given), ca.vertcat(*given)))
    return np.hstack([np.zeros((len(pattern), 1), dtype=bool), pattern])


def _parameter_pattern(forward: Forward) -> np.ndarray:
    """Return which parameters outputs and rates depend on directly, (3 n + size, p)."""
    parts = [*forward.outputs(*forward.inputs)[:3], forward.rates]
    return np.vstack([_pattern(ca.jacobian_sparsity(part, forward.path.p)) for part in parts])
