"""Friction in robot arms and the gap between a simulated arm and the recorded one.

What a script needs is here; each part of the package is imported when one of its names is first asked for::

    import stribeck

    arm = stribeck.load_arm("arm.toml")
    found = stribeck.diagnose(arm, stribeck.load_runs(["run_0.csv", "run_1.csv"], arm.n))
    print(found.verdict, found.named)
    stribeck.save_arm(found.models["corrected"], "corrected.toml")

To write an effect of one's own: :mod:`stribeck.effects`.
"""

from importlib import import_module
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from stribeck.arm import Arm, EffectEntry, Friction, Joint, Tolerance, load_arm, save_arm
    from stribeck.errors import InputError, StribeckError
    from stribeck.export import export_fmu
    from stribeck.export.validate import check_fmu
    from stribeck.gap import Diagnosis, diagnose
    from stribeck.gap.answer.files import write_diagnosis
    from stribeck.identify.findings import Identification
    from stribeck.identify.identification import identify_friction
    from stribeck.loop.analyse import analyse_loop
    from stribeck.loop.answers import Analysis
    from stribeck.report.diagnosis import write_report
    from stribeck.run import Run, load_run, load_runs, save_run
    from stribeck.simulate import Loop, load_loop, predict, simulate_loop

_HOMES = {
    "stribeck.arm": ("Arm", "EffectEntry", "Friction", "Joint", "Tolerance", "load_arm", "save_arm"),
    "stribeck.errors": ("InputError", "StribeckError"),
    "stribeck.export": ("export_fmu",),
    "stribeck.export.validate": ("check_fmu",),
    "stribeck.gap": ("Diagnosis", "diagnose"),
    "stribeck.gap.answer.files": ("write_diagnosis",),
    "stribeck.identify.findings": ("Identification",),
    "stribeck.identify.identification": ("identify_friction",),
    "stribeck.loop.analyse": ("analyse_loop",),
    "stribeck.loop.answers": ("Analysis",),
    "stribeck.report.diagnosis": ("write_report",),
    "stribeck.run": ("Run", "load_run", "load_runs", "save_run"),
    "stribeck.simulate": ("Loop", "load_loop", "predict", "simulate_loop"),
}
_HOME = {name: home for home, names in _HOMES.items() for name in names}

__all__ = [
    "Analysis", "Arm", "Diagnosis", "EffectEntry", "Friction", "Identification", "InputError", "Joint", "Loop", "Run",
    "StribeckError", "Tolerance", "analyse_loop", "check_fmu", "diagnose", "export_fmu", "identify_friction",
    "load_arm", "load_loop", "load_run", "load_runs", "predict", "save_arm", "save_run", "simulate_loop",
    "write_diagnosis", "write_report",
]  # fmt: skip


def __getattr__(name: str) -> Any:
    """Import a public name from its part of the package."""
    if name not in _HOME:
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
    return getattr(import_module(_HOME[name]), name)


def __dir__() -> list[str]:
    return sorted([*globals(), *__all__])
