"""Question: what would a user get from the tools at hand instead? All of them on the same cases, in one run.

Method: sealed cases of the independent plant, every other effect of its list, so that all stages have a share. This
package; MuJoCo's system identification toolbox with masses, armatures, damping and dry friction, as in its examples,
and once more with all that it has for effects (springs, motor offsets, delays), named where an interval excludes
nothing; PySINDy's ensembled STLSQ on the torque that the re-tuned model leaves, with a term for every static effect;
PEtab Select's AIC, AICc and BIC on this package's own fits; SciPy's least squares with all effects at once. Counted:
the likeliest name right (what a method says is as likely counts with it), wrong, and silence where nothing is hidden;
how many effects are named; friction against the true arm, its intervals, and processor time. This package is without
the forward check and the report. Its thresholds were found on other cases of the same plant, and its library knows
all hidden effects: a home game. MuJoCo has no falling friction, whatever it fits.
Needs ``pip install "mujoco[sysid]" pysindy petab-select``, an environment of its own if you like.
Expected: MuJoCo names nothing and is silent about it; criteria for white noise and the full model name something
always; PySINDy is by far the fastest. Source: each tool's documentation, defaults where it has them.
"""

from __future__ import annotations

import importlib.util
import shutil

import typer
from _output import OUT, write

from stribeck.blind.batch import diagnose_cases
from stribeck.blind.farm import Processes
from stribeck.blind.key import open_sealed
from stribeck.effects.registry import registry
from stribeck.withheld import KNOWN
from stribeck.withheld.plan import LEVELS, Order
from stribeck.withheld.seal import record_sealed

TOOLS = ("mujoco", "pysindy", "petab_select")


def main(
    single: int = 14,
    none: int = 6,
    effects: str = "",
    levels: str = ",".join(LEVELS),
    library: str = "",
    seed: int = 7000,
    jobs: int = 1,
    score_only: bool = False,
    fresh: bool = False,
) -> None:
    """Record, answer, compare; ``--library a,b`` has these candidates only, ``--score-only`` compares what there is."""
    if missing := [name for name in TOOLS if importlib.util.find_spec(name) is None]:
        print(f"not compared: {', '.join(missing)} not installed (pip install 'mujoco[sysid]' pysindy petab-select)")
        raise typer.Exit(1)
    from _side_by_side import answers_of_a_case, in_words, table
    from _side_by_side_figure import side_by_side_figure

    work = OUT / "side_by_side" / "work"
    if fresh:
        shutil.rmtree(work, ignore_errors=True)
    seen_directly = {name for name, effect in registry().items() if effect.direct}
    hidden = tuple(effects.split(",")) if effects else tuple(name for name in KNOWN if name not in seen_directly)[::2]
    order = Order(single, 0, none, 0, 0, hidden, tuple(levels.split(",")))
    if not (work / "key.json").exists():
        print("digest", record_sealed(order, work / "cases", work / "key.json", seed=seed, jobs=jobs, progress=print))
    if not score_only:
        without = [name for name in registry() if library and name not in library.split(",")]
        farm = Processes(jobs)
        diagnose_cases(work / "cases", work / "answers", farm=farm, leave_out=without, diagnoser=answers_of_a_case)
    result = table(open_sealed(work / "answers", work / "key.json", partial=score_only))
    print("\n".join(in_words(result)))
    print(f"written to {write('side_by_side', result, methods=side_by_side_figure(result))}")


if __name__ == "__main__":
    typer.run(main)
