"""Question: which of the paper's claims hold (4.3, 5, 6)? Five do, eight under a condition, four do not.

Method: one joint of 1 kg m^2 with the friction of A or B, continuous control unless said otherwise, event-accurate:
ramps at two velocities and two gains for k from 0 to 1.3; regulation with compensation on the desired and on the
measured velocity; the stick-slip threshold by bisection; adaptive and robust compensation; 100 draws of the paper's
readings.
Expected: every figure of the earlier analysis of this arm: the ramp errors to 0.5 %, the coth law to 0.1 %, thresholds
of 0.010, 0.039 and 0.072 rad/s at zeta 1, 0.5 and 0.25, the same for every k; where it differs, ``claims.toml`` says
so.
Source: paper, 2.3, 3, 4 to 6; Armstrong & Amin (1996); Southward et al. (1991); Canudas de Wit et al. (1991).
"""

from __future__ import annotations

import typer
from _claim_figures import curve_figure, cycle_figure, error_figure, remedy_figure, stick_slip_figure
from _claims import as_markdown
from _claims_curve import curve_claims
from _claims_cycle import cycle_claims, cycles, remedies, thresholds
from _claims_error import error_claims, ramps
from _output import write
from rich.console import Console
from rich.table import Table


def main(repeats: int = 100, seed: int = 0) -> None:
    """Measure, judge, and write the table."""
    errors, around, slow, helped = ramps(), cycles(), thresholds(), remedies()
    claims = curve_claims(repeats, seed) + error_claims(errors) + cycle_claims(around, slow, helped)
    count = {
        verdict: sum(one.verdict == verdict for one in claims) for verdict in ("holds", "holds if", "does not hold")
    }
    figures = {
        "errors": error_figure(errors),
        "cycles": cycle_figure(around),
        "stick_slip": stick_slip_figure(slow),
        "remedies": remedy_figure(helped),
        "curve": curve_figure(),
    }
    units = {"mrad": "1e-3 rad", "threshold": "rad/s", "error": "rad", "largest_kp": "N m/rad", "least_C2": "N m s/rad"}
    result = {"seed": seed, "units": units, "count": count, "claims": {one.key: one.row() for one in claims}}
    folder = write("claims", result, **figures)
    (folder / "claims.md").write_text(as_markdown(claims), encoding="utf-8")
    table = Table("claim", "section", "verdict", "why, or when")
    for one in claims:
        table.add_row(one.words["claim"], one.words["where"], one.verdict, one.words["why"])
    Console().print(table)
    print(f"written to {folder}")


if __name__ == "__main__":
    typer.run(main)
