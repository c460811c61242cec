"""An SSP 1.0 file: the arm's FMU and the controller's FMU, coupled."""

from __future__ import annotations

import tempfile
from collections.abc import Sequence
from pathlib import Path
from xml.etree import ElementTree as ET

from stribeck.arm import Arm
from stribeck.errors import InputError
from stribeck.export.archive import write_archive
from stribeck.export.controller.export import check_controller, export_controller
from stribeck.export.export import export_fmu
from stribeck.simulate import Loop
from stribeck.simulate.axis import start_position

_COMMON = "http://ssp-standard.org/SSP1/SystemStructureCommon"
_SYSTEM = "http://ssp-standard.org/SSP1/SystemStructureDescription"
_VALUES = "http://ssp-standard.org/SSP1/SystemStructureParameterValues"


def export_system(
    arm: Arm, loop: Loop, out: Path, *, platforms: Sequence[str] | None = None, controlled: Arm | None = None
) -> None:
    """Write an SSP 1.0 file with the FMI 2 FMUs of an arm and of its controllers, and their connections.

    Parameters
    ----------
    arm : Arm
        The plant.
    loop : Loop
        Sampled, with a controller for each joint.
    out : path
        The file to write, ending in ``.ssp``, whole or not at all.
    platforms : sequence of str or None
        As in `stribeck.export.export_fmu`.
    controlled : Arm or None
        What the controllers take the arm to be, where that is another.

    Notes
    -----
    Masters of SSP step all components at once and pass values on afterwards, so that every torque reaches the arm one
    communication step after its sample. Communicate at the sample time and it is the loop with ``delay_samples`` one
    higher; communicate faster and less is lost.
    """
    out = Path(out)
    if out.suffix != ".ssp":
        raise InputError(f"{out}: not the name of an SSP file", out.suffix or "no suffix", "let it end in .ssp")
    check_controller(controlled or arm, loop)
    with tempfile.TemporaryDirectory(prefix="stribeck.ssp.") as name:
        folder = Path(name)
        export_fmu(arm, folder / "arm.fmu", fmi=2, platforms=platforms)
        export_controller(controlled or arm, loop, folder / "controller.fmu", fmi=2, platforms=platforms)
        content: dict[str, bytes | str] = {
            f"resources/{file}": (folder / file).read_bytes() for file in ("arm.fmu", "controller.fmu")
        }
    content["SystemStructure.ssd"] = system_structure(arm, loop)
    write_archive(content, out)


def system_structure(arm: Arm, loop: Loop) -> str:
    """Return the text of ``SystemStructure.ssd``."""
    ET.register_namespace("ssd", _SYSTEM)
    ET.register_namespace("ssc", _COMMON)
    ET.register_namespace("ssv", _VALUES)
    root = ET.Element(f"{{{_SYSTEM}}}SystemStructureDescription", {"version": "1.0", "name": f"loop around {arm.name}"})
    system = ET.SubElement(root, f"{{{_SYSTEM}}}System", {"name": "loop"})
    elements = ET.SubElement(system, f"{{{_SYSTEM}}}Elements")
    straight = arm.joints[0].kind == "prismatic"
    position, speed, torque = ("m", "m/s", "N") if straight else ("rad", "rad/s", "N.m")
    shared = [("q", position), ("dq", speed)]
    start = start_position(arm, loop)
    plant = _component(elements, "arm", arm.n, outputs=shared, inputs=[("tau", torque)])
    if start.any():
        _start(plant, {f"q_start[{k + 1}]": float(value) for k, value in enumerate(start)}, position)
    outputs = [("tau", torque), ("q_ref", position), ("dq_ref", speed)]
    _component(elements, "controller", arm.n, outputs=outputs, inputs=shared)
    links = ET.SubElement(system, f"{{{_SYSTEM}}}Connections")
    for k in range(1, arm.n + 1):
        for name, source, target in (
            ("q", "arm", "controller"),
            ("dq", "arm", "controller"),
            ("tau", "controller", "arm"),
        ):
            ends = {"startElement": source, "startConnector": f"{name}[{k}]"}
            ends |= {"endElement": target, "endConnector": f"{name}[{k}]"}
            ET.SubElement(links, f"{{{_SYSTEM}}}Connection", ends)
    ET.SubElement(root, f"{{{_SYSTEM}}}DefaultExperiment", {"startTime": "0.0", "stopTime": repr(loop.duration)})
    ET.indent(root)
    return '<?xml version="1.0" encoding="UTF-8"?>\n' + ET.tostring(root, encoding="unicode") + "\n"


def _component(
    elements: ET.Element, name: str, n: int, *, outputs: list[tuple[str, str]], inputs: list[tuple[str, str]]
) -> ET.Element:
    values = {"name": name, "type": "application/x-fmu-sharedlibrary", "source": f"resources/{name}.fmu"}
    component = ET.SubElement(elements, f"{{{_SYSTEM}}}Component", values)
    connectors = ET.SubElement(component, f"{{{_SYSTEM}}}Connectors")
    for kind, entries in (("output", outputs), ("input", inputs)):
        for key, unit in entries:
            for k in range(1, n + 1):
                connector = ET.SubElement(connectors, f"{{{_SYSTEM}}}Connector", {"name": f"{key}[{k}]", "kind": kind})
                ET.SubElement(connector, f"{{{_COMMON}}}Real", {"unit": unit})
    return component


def _start(component: ET.Element, values: dict[str, float], unit: str) -> None:
    bindings = ET.SubElement(component, f"{{{_SYSTEM}}}ParameterBindings")
    binding = ET.SubElement(bindings, f"{{{_SYSTEM}}}ParameterBinding")
    inner = ET.SubElement(binding, f"{{{_SYSTEM}}}ParameterValues")
    held = ET.SubElement(inner, f"{{{_VALUES}}}ParameterSet", {"version": "1.0", "name": "start"})
    parameters = ET.SubElement(held, f"{{{_VALUES}}}Parameters")
    for name, value in values.items():
        parameter = ET.SubElement(parameters, f"{{{_VALUES}}}Parameter", {"name": name})
        ET.SubElement(parameter, f"{{{_VALUES}}}Real", {"value": repr(value), "unit": unit})
