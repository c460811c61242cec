"""Question: which residual and which rule name hidden effects, and which cry wolf? How the method was chosen.

Method: cases of the independent plant, sealed as in `blind_effects.py`, searched once each. All rules then judge the
same fits, those of the search's first step: BIC and the likelihood ratio on the fitted runs as if residuals were
white, a score test whose units are blocks of a second, the gain on held-out runs by its t value over blocks, stacked
predictive densities, and the shipped rule, which goes on to further effects. Each looks at torque along the recorded
motion, at windows of 0.5 s of forward simulation, or at both; the shipped one looks at torque, and for "both" the
simulation may veto. Fits are by torque in any case: what is compared is which residual to judge them by. Where rivals
cannot be told apart, all rules get the class of the shipped one. Effects that the records show by themselves (encoder
steps, a late velocity) are left out: they need no rule. The shipped rule's thresholds were found on other cases of the
same plant, the others' are those of textbooks; so the best threshold that these very cases would have given each of
them is told as well, which flatters them.
Expected: rules for white noise name something nearly always, also where there is nothing; simulation adds little to
torque. (The latter was wrong: judged by motion, each rule but the shipped one names fewer wrong ones.)
Source: Kass & Raftery (1995) for BIC, Yao et al. (2018) for stacking, Newey & West (1987) for robust scores.
"""

from __future__ import annotations

import shutil

import typer
from _decision_figure import decision_figure
from _decision_fits import fits_of_a_case
from _decision_table import in_words, table
from _output import OUT, write

from stribeck.blind.batch import diagnose_cases
from stribeck.blind.farm import Processes
from stribeck.blind.key import open_sealed
from stribeck.effects.registry import registry
from stribeck.withheld import KNOWN
from stribeck.withheld.plan import LEVELS, Order
from stribeck.withheld.seal import record_sealed


def main(
    single: int = 28,
    none: int = 12,
    unknown: int = 6,
    left_out: int = 6,
    effects: str = "",
    levels: str = ",".join(LEVELS),
    library: str = "",
    seed: int = 6000,
    jobs: int = 1,
    score_only: bool = False,
    fresh: bool = False,
) -> None:
    """Record, search, judge; ``--library a,b`` has these candidates only, ``--score-only`` judges what there is."""
    work = OUT / "decision_rules" / "work"
    if fresh:
        shutil.rmtree(work, ignore_errors=True)
    seen_directly = {name for name, effect in registry().items() if effect.direct}
    hidden = tuple(effects.split(",")) if effects else tuple(name for name in KNOWN if name not in seen_directly)
    order = Order(single, 0, none, unknown, left_out, hidden, tuple(levels.split(",")))
    if not (work / "key.json").exists():
        print("digest", record_sealed(order, work / "cases", work / "key.json", seed=seed, jobs=jobs, progress=print))
    if not score_only:
        without = [name for name in registry() if library and name not in library.split(",")]
        farm = Processes(jobs)
        diagnose_cases(work / "cases", work / "fits", farm=farm, leave_out=without, diagnoser=fits_of_a_case)
    result = table(open_sealed(work / "fits", work / "key.json", partial=score_only))
    for line in in_words(result):
        print(line)
    print(f"written to {write('decision_rules', result, rules=decision_figure(result))}")


if __name__ == "__main__":
    typer.run(main)
