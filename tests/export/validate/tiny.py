"""FMUs made by hand: a first-order lag, well or badly behaved, in archives that are sound or hostile."""

import zipfile
from collections.abc import Mapping
from functools import cache
from pathlib import Path

import fmpy

from stribeck.compiler import build
from stribeck.export.validate.binaries import header_functions

DESCRIPTION = """\
<?xml version="1.0" encoding="UTF-8"?>
<fmiModelDescription fmiVersion="2.0" modelName="tiny" guid="{tiny}" generationTool="by hand">
  <CoSimulation modelIdentifier="tiny" canHandleVariableCommunicationStepSize="true"/>
  <DefaultExperiment startTime="0" stopTime="0.5" stepSize="0.05"/>
  <ModelVariables>
    <ScalarVariable name="u" valueReference="0" causality="input"><Real start="0"/></ScalarVariable>
    <ScalarVariable name="x" valueReference="1" causality="output" initial="calculated"><Real/></ScalarVariable>
    <ScalarVariable name="T" valueReference="2" causality="parameter" variability="tunable">
      <Real start="0.5"/></ScalarVariable>
  </ModelVariables>
  <ModelStructure>
    <Outputs><Unknown index="2"/></Outputs>
    <InitialUnknowns><Unknown index="2"/></InitialUnknowns>
  </ModelStructure>
</fmiModelDescription>
"""
CRASH, HANG, NAN, MEMORY, EXIT, ERROR, VERSION, RANDOM = range(1, 9)
HERE = f"binaries/{fmpy.platform}/tiny.so"
SOURCE = Path(__file__).with_name("tiny.c").read_text()


def source(way: int = 0, *, without: str = "") -> str:
    """The C source: written functions, and stubs for all others of FMI 2 but ``without``."""
    written = [name for name in header_functions(2) if f"{name}(" in SOURCE]
    stubs = [f"int {name}(void) {{ return 0; }}" for name in header_functions(2) if name not in written]
    return "\n".join([f"#define WAY {way}", SOURCE, *(stub for stub in stubs if f" {without}(" not in stub)])


@cache
def binary(way: int = 0, without: str = "") -> bytes:
    return build(source(way, without=without)).read_bytes()


def tiny(
    path: Path, files: Mapping[str, bytes | str] | None = None, *, way: int = 0, description: str = DESCRIPTION
) -> Path:
    """Write the lag's FMU, with further or other files."""
    content: dict[str, bytes | str] = {"modelDescription.xml": description, HERE: binary(way), **(files or {})}
    with zipfile.ZipFile(path, "w", zipfile.ZIP_DEFLATED) as archive:
        for name, data in content.items():
            archive.writestr(name, data)
    return path
