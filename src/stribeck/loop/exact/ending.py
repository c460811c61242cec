"""What a loop ends in from one start, and the answer for each joint that follows from it."""

from __future__ import annotations

from collections.abc import Callable, Collection, Mapping
from dataclasses import dataclass, field, replace

import numpy as np
from numpy.typing import NDArray

from stribeck.arm import unit_at
from stribeck.loop.cycle import STEADY, WORDS, Cycle, CycleTrace, Verdict
from stribeck.loop.exact.place import Place
from stribeck.loop.exact.rest import holds, seen_deviations, winding
from stribeck.loop.exact.rounds import NONE, Rounds
from stribeck.loop.exact.stall import stalled
from stribeck.loop.exact.turns import CREEP, TINY, dies_out, fold_of, weighted, whole_rounds

Floats = NDArray[np.float64]
FRAGILE = "creeps to rest without ever stopping: noise, or rounding, would start a cycle"
WINDS_UP = "it sticks for longer than the other joints took to settle, and winds up"
OPEN = "its motion had not settled when that of the other joints had"
_FEW_SAMPLES = 4  # rounds of so many samples, and as many more for each one of delay, are chatter
_ROWS, _MOST_ROWS = 801, 40_001  # of one period: while the joint moves, and in all
_UNLIKE = 1.2  # the swing of all rounds together over the mean of one, from which on they are no rounds of one cycle
_SAME_ROUND = 0.03  # of the range: between turns of a sampled loop, as they fall within an interval


@dataclass(frozen=True)
class Ending:
    """What a loop ends in.

    Attributes
    ----------
    kind : str
        ``rest``, ``periodic``, ``roughly`` (a lasting motion that repeats only on average), ``unbounded`` or
        ``undetermined``.
    place : Place
        At rest; or at a turn, from where the motion goes on.
    turns : structured array
        Of one period, or of the rounds that averages are over.
    span : float
        Time that the turns cover, s.
    multipliers : array of complex
    repeat : float
        Time after which a sampled loop's motion repeats exactly, s; 0 where it is not known to.
    watch : int
        The joint at whose turn a periodic motion's place is.
    open : set of int
        Joints whose motion has not settled while that of the others has.
    left : mapping
        Joints that are left behind for good, and why in words; they take no part in what the others end in.
    still : set of int
        Joints that stand still beside a periodic motion.
    status : str
        ``ok``, or what the method could not do.
    """

    kind: str
    place: Place
    turns: np.ndarray = field(default_factory=lambda: np.zeros(0))
    span: float = 0.0
    multipliers: tuple[complex, ...] = ()
    status: str = "ok"
    watch: int = -1
    repeat: float = 0.0
    open: frozenset[int] = frozenset()
    left: Mapping[int, str] = field(default_factory=dict)
    still: frozenset[int] = frozenset()

    @property
    def lasts(self) -> bool:
        """Whether it is a motion that does not die out."""
        return self.kind in ("periodic", "roughly")


def all_die(
    rounds: Rounds,
    place: Place,
    turns: np.ndarray,
    left: Collection[int],
    dies: Callable[[np.ndarray], bool] = dies_out,
) -> bool:
    """Tell whether a loop comes to rest, by the last turns of every joint.

    One that winds up does not, nor one that a filter holds by a sign from before. Those that are ``left``
    behind do not count.

    Parameters
    ----------
    rounds : Rounds
    place : Place
        Where the loop is now.
    turns : structured array
        As of :class:`stribeck.loop.exact.place.Stretch`.
    left : collection of int
        Joints that are left behind.
    dies : callable
        Whether the turns of one joint die out.
    """
    still = not winding(rounds, place, CREEP) - set(left)
    turns = turns[~np.isin(turns["joint"], list(left))] if len(turns) else turns
    joints = [int(j) for j in np.unique(turns["joint"])] if len(turns) else []
    if not (still and joints and all(dies(turns[turns["joint"] == j]) for j in joints)):
        return False
    filtered = [j for j in joints if rounds.sampled and rounds.axes[j].filter > 0.0 and rounds.rate(j) == 0.0]
    return not filtered or holds(rounds, place, filtered)


def answers(rounds: Rounds, ending: Ending, *, alike: bool = True) -> dict[str, Cycle]:
    """Return each controlled joint's answer.

    Parameters
    ----------
    rounds : Rounds
    ending : Ending
    alike : bool
        Whether a lasting motion whose swings are not alike is no cycle; else it is called by its mean.
    """
    traces = _traces(rounds, ending) if ending.lasts else {}
    left = _left(rounds, ending)
    out = {}
    for entry in rounds.loop.joints:
        j = rounds.index(entry.joint)
        cycle = Cycle("undetermined", status=left[j], left=True) if j in left else _answer(rounds, ending, j, alike)
        out[entry.joint] = replace(cycle, trace=traces.get(j)) if cycle.cycles else cycle
    return out


def _answer(rounds: Rounds, ending: Ending, j: int, alike: bool) -> Cycle:
    steady = -float(seen_deviations(rounds, ending.place)[j])
    mine: np.ndarray = ending.turns[ending.turns["joint"] == j] if ending.lasts else np.zeros(0)
    if ending.kind == "rest":
        creeps = ending.place.values[rounds.layout.modes][j] != 0.0 and not rounds.engine.forward.bristles[j]
        ratio = rounds.axes[j].ratio if rounds.entry(rounds.arm.names[j]).compensation.kind == "feedback" else 0.0
        fragile = creeps and rounds.rate(j) == 0.0 and ratio > 1.0 and rounds.break_away(j) > 0.0
        return Cycle(
            "rest", steady_error=steady, status=FRAGILE if fragile and ending.status == "ok" else ending.status
        )
    if ending.kind == "unbounded":
        return Cycle("unbounded", stable=False, status=ending.status)
    if ending.kind == "undetermined":
        return Cycle("undetermined", status=ending.status)
    if _stands(mine):
        if j in winding(rounds, ending.place, TINY):
            return Cycle("undetermined", status=WINDS_UP)
        return Cycle("rest", steady_error=steady, status=ending.status)
    if j in ending.open:
        return Cycle("undetermined", status=OPEN)
    amplitude, period, stuck = size_of(ending, mine)
    averaged = ending.kind == "roughly" and not rounds.noisy
    if alike and averaged and (whole := _whole(mine)) > _UNLIKE * amplitude:
        return Cycle("undetermined", status=_unlike(rounds, j, amplitude, whole))
    roots = tuple(_plain(root) for root in ending.multipliers)
    return Cycle(
        verdict=_verdict(rounds, j, period, stuck), amplitude=amplitude, period=period,
        peak_velocity=float(mine["speed"].max() if ending.kind == "periodic" else weighted(mine["speed"])),
        stick_fraction=stuck / period, multipliers=roots,
        stable=bool(max(abs(root) for root in roots) < 1.0) if roots else None,
        status=ending.status,
    )  # fmt: skip


def _left(rounds: Rounds, ending: Ending) -> Mapping[int, str]:
    """Return the joints that are left behind; looked for where the search had not met them."""
    if ending.kind == "unbounded":
        return {}
    moved = [j for j in range(rounds.n) if ending.lasts and not _stands(ending.turns[ending.turns["joint"] == j])]
    return {**stalled(rounds, ending.place, {*moved, *ending.left}), **ending.left}


def _stands(mine: np.ndarray) -> bool:
    """Tell whether one joint's turns are so small that it stands still."""
    return len(mine) == 0 or bool(np.ptp([mine["low"].min(), mine["high"].max()]) < 2.0 * TINY)


def _whole(mine: np.ndarray) -> float:
    """Return half the peak-to-peak position over all rounds of one joint, rad."""
    return 0.5 * float(mine["high"][1:].max(initial=-np.inf) - mine["low"][1:].min(initial=np.inf))


def _unlike(rounds: Rounds, j: int, amplitude: float, whole: float) -> str:
    unit = unit_at("rad", rounds.arm.joints[j].kind)
    sizes = f"±{1e3 * amplitude:.3g} m{unit} on average, ±{1e3 * whole:.3g} m{unit} all together"
    return f"its swings are not alike, {sizes}: no cycle of one period"


def size_of(ending: Ending, mine: np.ndarray) -> tuple[float, float, float]:
    """Return amplitude (rad) and period (s) of one joint, by its turns, and the time stuck in one."""
    spread = 0.5 * (mine["high"] - mine["low"])
    if ending.kind == "periodic":
        whole = 0.5 * float(mine["high"].max() - mine["low"].min())
        alike = np.ptp(spread) <= 1e-6 * whole and abs(whole - spread[0]) <= 1e-6 * whole
        rounds = len(mine) if alike else 1
        return whole, ending.span / rounds, float(mine["stuck"].sum()) / rounds
    mine = whole_rounds(mine)
    if len(mine) < 2:
        return 0.5 * float(np.max(spread)), ending.span, 0.0
    fold = fold_of(mine["deviation"][1:], _SAME_ROUND * float(mine["high"].max() - mine["low"][1:].min()))
    count = (len(mine) - 1) // fold * fold
    high, low, stuck = (mine[key][-count:].reshape(-1, fold) for key in ("high", "low", "stuck"))
    period = weighted(np.diff(mine["time"])[-count:].reshape(-1, fold).sum(axis=1))
    if ending.repeat > 0.0:
        period = ending.repeat / max(round(ending.repeat / period), 1)
    return weighted(0.5 * (high.max(axis=1) - low.min(axis=1))), period, weighted(stuck.sum(axis=1))


def _verdict(rounds: Rounds, j: int, period: float, stuck: float) -> Verdict:
    axis, ts = rounds.axes[j], rounds.loop.sample_time
    reaction = (axis.delay + 2) * ts  # a sampled controller cannot let go sooner: no sticking of its own
    if ts > 0.0 and period <= _FEW_SAMPLES * (axis.delay + 2) * ts:
        return "chatter"
    if stuck <= max(2.0 * reaction, 1e-9 * period):
        return "sliding_cycle"
    return "hunting" if rounds.rate(j) == 0.0 else "stick_slip"


def _plain(root: complex) -> float | complex:
    return float(root.real) if root.imag == 0.0 else complex(root)


def _traces(rounds: Rounds, ending: Ending) -> dict[int, CycleTrace]:
    """Return one period of each joint: of the motion where it repeats, else of the first round after it settled."""
    joints = [ending.turns[ending.turns["joint"] == j] for j in np.unique(ending.turns["joint"])]
    sizes = [size_of(ending, mine) for mine in joints]
    span = ending.span if ending.kind != "roughly" else max(period for _, period, _ in sizes)
    moves = [1.0 - stuck / period for (_, period, stuck), mine in zip(sizes, joints, strict=True) if not _stands(mine)]
    rows = int(min(_ROWS / max(min(moves, default=1.0), 1e-9), _MOST_ROWS))
    step = span / (rows - 1)
    if rounds.sampled:
        step = rounds.loop.sample_time
        rows = int(np.ceil(span / step)) + 1
    done = rounds.run(ending.place, NONE, rows=rows, step=step, quiet=False)
    record, time = done.record, step * np.arange(rows, dtype=np.float64)
    kept = np.isfinite(record[:, 0]).all(axis=1)
    return {
        j: CycleTrace(time[kept], record[kept, 0, j], record[kept, 1, j], record[kept, 2, j] == 0.0)
        for j in range(rounds.n)
    }


def gather(found: Mapping[str, Mapping[str, Cycle]], joint: str, moves: bool) -> Cycle:
    """Return the answer for a joint from those of all starts.

    The loop's own start decides, unless no joint cycles from there and a cycle draws this one in from another; not so
    where it is left behind for good. ``moves`` is whether its reference does: what is called rest then slides.
    """
    basin = {start: cycles[joint].verdict for start, cycles in found.items()}
    chosen = found["own"][joint]
    if not chosen.left and not any(cycle.cycles or cycle.verdict == "unbounded" for cycle in found["own"].values()):
        for start in ("large", "small"):
            if start in found and found[start][joint].cycles:
                other = found[start][joint]
                ends = STEADY if moves and chosen.verdict == "rest" else WORDS.get(chosen.verdict, chosen.verdict)
                told = f"from a {start} start; {ends} from the loop's own"
                chosen = replace(other, status=told if other.status == "ok" else f"{other.status}; {told}")
                break
            if start in found and found[start][joint].verdict == "unbounded" and chosen.status == "ok":
                chosen = replace(chosen, status=f"unbounded from a {start} start")
    return replace(chosen, basin=basin)
