"""The C source of one arm: generated equations, then the runtime that is the same for all."""

from __future__ import annotations

from collections.abc import Mapping
from importlib.resources import files

import casadi as ca

from stribeck.model.effect import SensingEffect
from stribeck.model.forward import Forward

RUNTIME = ("solver.h", "contact.h", "advance.h", "report.h", "windows.h", "control.h", "loop.h", "mirrored.h")
CONTROLLER_STATES = 6  # a joint, of a continuous controller


def runtime_text(name: str) -> str:
    """Return one file of the runtime."""
    return (files("stribeck.simulate") / "c" / name).read_text(encoding="utf-8")


def model_source(
    forward: Forward, more: Mapping[str, ca.Function] | None = None, *, controller_states: int = CONTROLLER_STATES
) -> str:
    """Return the generated part: functions, sizes and tables.

    Parameters
    ----------
    forward : Forward
    more : mapping of str to casadi.Function
        Further functions, by the prefix of their sizes.
    controller_states : int
        Most states that a controller adds, a joint.
    """
    functions = {"SB_FLOW": forward.flow, "SB_JACOBIAN": forward.jacobian, "SB_OUTPUTS": forward.outputs}
    functions |= more or {}
    generator = ca.CodeGenerator("model", {"with_header": False})
    for function in functions.values():
        generator.add(function)
    lines = ["#define CASADI_SYMBOL_EXPORT static", generator.dump()]
    for name, function in functions.items():
        sizes = {"ARG": function.sz_arg(), "RES": function.sz_res(), "IW": function.sz_iw(), "W": function.sz_w()}
        lines += [f"#define {name}_{key} {size}" for key, size in sizes.items()]
    delays = "".join(f"{{{joint}, {place}}}, " for joint, place in forward.delays)
    waves = "".join(f"{{{place}, {multiple}}}, " for place, multiple in forward.waves)
    lines += [
        f"#define SB_N {forward.n}",
        f"#define SB_NS {forward.size}",
        f"#define SB_NP {len(forward.path.entries)}",
        f"#define SB_NZ {controller_states * forward.n}",
        f"#define SB_SENSING {int(any(isinstance(place.effect, SensingEffect) for place in forward.path.placed))}",
        f"#define SB_BRISTLES {{{', '.join(str(int(flag)) for flag in forward.bristles)}}}",
        f"#define SB_DELAYS {{{delays}{{-1, -1}}}}",
        f"#define SB_WAVES {{{waves}{{-1, 0}}}}",
    ]
    return "\n".join(lines) + "\n"


def library_source(forward: Forward) -> str:
    """Return the whole translation unit of the engine's shared library."""
    export = "#ifdef _WIN32\n#define SB_EXPORT __declspec(dllexport)\n#else\n#define SB_EXPORT\n#endif\n"
    body = "".join(runtime_text(name) for name in RUNTIME)
    includes = "".join(f'#include "{name}"\n' for name in RUNTIME)
    for line in includes.splitlines():
        body = body.replace(line + "\n", "")
    return model_source(forward) + export + body
