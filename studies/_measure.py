"""Time and memory of a piece of work, and how they stand against limits."""

from __future__ import annotations

import os
import statistics
import threading
import time
from collections.abc import Callable, Iterator, Mapping
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from matplotlib.figure import Figure

from stribeck.report.style import COLOUR, drawn, heading, new_figure

EVERY = 0.1  # s


Clock = Callable[[], float]
wall: Clock = time.perf_counter
processor: Clock = time.process_time  # of one thread's work: other work on the machine does not count


def fastest(work: Callable[[], object], times: int, clock: Clock = wall) -> float:
    """Return the shortest time of several calls, s, which other work on the machine disturbs least."""
    took = []
    for _ in range(times):
        started = clock()
        work()
        took.append(clock() - started)
    return min(took)


def in_turn(
    first: Callable[[], object], second: Callable[[], object], times: int, clock: Clock = wall
) -> tuple[float, float]:
    """Return the median times of two works, s, called in turn so that both meet the same machine."""
    pairs = [(fastest(first, 1, clock), fastest(second, 1, clock)) for _ in range(times)]
    one, other = zip(*pairs, strict=True)
    return statistics.median(one), statistics.median(other)


@dataclass
class Peak:
    """Most memory that this process and its children held together, MB; 0 where the system does not tell."""

    megabytes: float = 0.0


@contextmanager
def peak_memory() -> Iterator[Peak]:
    """Watch memory, shared pages counted once, while the block runs; needs Linux."""
    peak, done = Peak(), threading.Event()

    def watch() -> None:
        while not done.wait(EVERY):
            peak.megabytes = max(peak.megabytes, sum(map(_memory, _family(os.getpid()))))

    thread = threading.Thread(target=watch, daemon=True)
    thread.start()
    try:
        yield peak
    finally:
        done.set()
        thread.join()


def _family(root: int) -> list[int]:
    parents: dict[int, int] = {}
    for stat in Path("/proc").glob("[0-9]*/stat"):
        try:
            after_name = stat.read_text().rpartition(")")[2].split()
        except OSError:  # ended meanwhile
            continue
        parents[int(stat.parent.name)] = int(after_name[1])
    found = [root]
    for pid in found:
        found += [child for child, parent in parents.items() if parent == pid]
    return found


def _memory(pid: int) -> float:
    try:
        lines = Path(f"/proc/{pid}/smaps_rollup").read_text().splitlines()
    except OSError:
        return 0.0
    return sum(float(line.split()[1]) for line in lines if line.startswith("Pss:")) / 1024.0


@drawn
def against(measured: Mapping[str, Any], limits: Mapping[str, float]) -> Figure:
    """Draw what was measured as a share of its limit."""
    names = [name for name in limits if name in measured]
    share = [measured[name] / limits[name] for name in names]
    figure = new_figure(1.2 + 0.45 * len(names))
    ax = figure.add_subplot()
    ax.barh(names, share, color=[COLOUR["corrected"] if s < 1.0 else COLOUR["as_given"] for s in share])
    for row, (name, s) in enumerate(zip(names, share, strict=True)):
        ax.text(s, row, f" {measured[name]:.3g} of {limits[name]:g}", va="center", fontsize=9)
    ax.axvline(1.0, color=COLOUR["measured"], linewidth=0.8)
    ax.set(xlim=(0.0, 1.3 * max(1.0, *share)), xlabel="share of the limit")
    ax.invert_yaxis()
    heading(figure, f"{sum(s < 1.0 for s in share)} of {len(share)} limits hold")
    return figure
