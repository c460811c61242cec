"""A small importer of our own: it calls the binary as the standard says, one method a step of the state machine."""

import ctypes
import xml.etree.ElementTree as ElementTree
import zipfile
from collections.abc import Callable, Sequence
from pathlib import Path

import numpy as np

OK, WARNING, DISCARD, ERROR = range(4)
_D, _P, _U, _S, _I = ctypes.c_double, ctypes.c_void_p, ctypes.c_uint32, ctypes.c_size_t, ctypes.c_int
LOG2 = ctypes.CFUNCTYPE(None, _P, ctypes.c_char_p, _I, ctypes.c_char_p, ctypes.c_char_p, ctypes.c_char_p)
LOG3 = ctypes.CFUNCTYPE(None, _P, _I, ctypes.c_char_p, ctypes.c_char_p)


class _Callbacks(ctypes.Structure):
    _fields_ = [("logger", LOG2), ("allocate", _P), ("free", _P), ("finished", _P), ("environment", _P)]


class _EventInfo(ctypes.Structure):
    _fields_ = [(name, _I) for name in ("needed", "terminate", "nominals", "values", "defined")] + [("next", _D)]


class Fmu:
    """An FMU's description and binary; any number of instances."""

    def __init__(self, path: Path) -> None:
        self.path = path
        with zipfile.ZipFile(path) as archive:
            root = ElementTree.fromstring(archive.read("modelDescription.xml"))
            self.names = archive.namelist()
            binary = next(n for n in self.names if n.startswith(("binaries/linux64/", "binaries/x86_64-linux/")))
            place = path.with_suffix("") / binary
            if not place.exists():  # a library that is loaded must not be written to
                archive.extract(binary, path.with_suffix(""))
            self.library = ctypes.CDLL(str(place))
        self.fmi = int(root.attrib["fmiVersion"][0])
        self.token = root.attrib["guid" if self.fmi == 2 else "instantiationToken"]
        variables = root.find("ModelVariables")
        self.variables = list(variables) if variables is not None else []
        self.vr = {v.attrib["name"]: int(v.attrib["valueReference"]) for v in self.variables}
        self.states = [name[4:-1] for name in self.vr if name.startswith("der(")]
        self.indicators = sum(name.endswith("event_indicator") for name in self.vr)

    def instance(self, kind: str = "cs", **more: bool) -> "Instance":
        return Instance(self, kind, **more)


class Instance:
    """One instance, ``kind`` "cs" or "me"; ``log`` holds what it said as (status, category, text)."""

    def __init__(self, fmu: Fmu, kind: str, *, event_mode: bool = False, early: bool = False, log_on: bool = True):
        self.fmu, self.kind, self.log = fmu, kind, list[tuple[int, str, str]]()
        lib, token = fmu.library, fmu.token.encode()
        if fmu.fmi == 2:
            self._callback = LOG2(lambda e, n, s, c, f, text: self.log.append((s, c.decode(), text.decode())))
            self._callbacks = _Callbacks(self._callback)
            lib.fmi2Instantiate.restype = _P
            self.c = lib.fmi2Instantiate(
                b"it", _I(kind != "me"), token, b"", ctypes.byref(self._callbacks), _I(0), _I(log_on)
            )
        else:
            self._log = LOG3(lambda e, s, c, text: self.log.append((s, c.decode(), text.decode())))
            no, on = ctypes.c_bool(False), ctypes.c_bool(log_on)
            if kind == "me":
                lib.fmi3InstantiateModelExchange.restype = _P
                self.c = lib.fmi3InstantiateModelExchange(b"it", token, b"", no, on, None, self._log)
            else:
                lib.fmi3InstantiateCoSimulation.restype = _P
                modes = ctypes.c_bool(event_mode), ctypes.c_bool(early)
                self.c = lib.fmi3InstantiateCoSimulation(
                    b"it", token, b"", no, on, *modes, None, _S(0), None, self._log, None
                )

    def call(self, name2: str, *arguments: object, name3: str = "") -> int:
        """Call a function that both versions have; FMI 3's name is the same but for what is given."""
        name = f"fmi2{name2}" if self.fmu.fmi == 2 else f"fmi3{name3 or name2}"
        return int(getattr(self.fmu.library, name)(_P(self.c), *arguments))

    def _vrs(self, names: Sequence[str | int]) -> ctypes.Array[ctypes.c_uint32]:
        return (_U * len(names))(*[self.fmu.vr[n] if isinstance(n, str) else n for n in names])

    def try_set(self, values: dict[str, float]) -> int:
        array = (_D * len(values))(*values.values())
        more = () if self.fmu.fmi == 2 else (_S(len(values)),)
        return self.call("SetReal", self._vrs(list(values)), _S(len(values)), array, *more, name3="SetFloat64")

    def set(self, **values: float) -> None:
        self.put(values)

    def put(self, values: dict[str, float]) -> None:
        assert self.try_set(values) == OK, self.log

    def get(self, *names: str | int) -> np.ndarray:
        array = (_D * len(names))()
        more = () if self.fmu.fmi == 2 else (_S(len(names)),)
        status = self.call("GetReal", self._vrs(names), _S(len(names)), array, *more, name3="GetFloat64")
        assert status == OK, self.log
        return np.array(array)

    def get_integer(self, *names: str) -> list[int]:
        array = (ctypes.c_int32 * len(names))()
        more = () if self.fmu.fmi == 2 else (_S(len(names)),)
        assert self.call("GetInteger", self._vrs(names), _S(len(names)), array, *more, name3="GetInt32") == OK
        return list(array)

    def enter(self, start: float = 0.0, tolerance: float = 1e-8) -> None:
        """Enter initialization mode."""
        if self.fmu.fmi == 2:
            assert self.call("SetupExperiment", _I(1), _D(tolerance), _D(start), _I(0), _D(0.0)) == OK
            assert self.call("EnterInitializationMode") == OK
            return
        defined, undefined = ctypes.c_bool(True), ctypes.c_bool(False)
        more = defined, _D(tolerance), _D(start), undefined, _D(0.0)
        assert self.call("EnterInitializationMode", *more) == OK

    def begin(
        self, values: dict[str, float] | None = None, *, start: float = 0.0, tolerance: float = 1e-8
    ) -> "Instance":
        """Pass initialization; Model Exchange ends in continuous-time mode, Co-Simulation in step mode."""
        self.put(values or {})
        self.enter(start, tolerance)
        assert self.call("ExitInitializationMode") == OK
        if self.kind == "me":
            self.update()
            assert self.call("EnterContinuousTimeMode") == OK
        return self

    def update(self) -> bool:
        """Run the event iteration, which must end within one call; tell whether a state jumped."""
        if self.fmu.fmi == 2:
            info = _EventInfo()
            assert self.call("NewDiscreteStates", ctypes.byref(info)) == OK
            assert not info.needed
            assert not info.terminate
            return bool(info.values)
        flags, when = [ctypes.c_bool() for _ in range(5)], _D()
        assert self.call("", *map(ctypes.byref, flags), ctypes.byref(when), name3="UpdateDiscreteStates") == OK
        assert not flags[0].value
        return flags[3].value

    def step(self, t: float, h: float) -> int:
        if self.fmu.fmi == 2:
            return self.call("DoStep", _D(t), _D(h), _I(1))
        self.flags, self.reached = [ctypes.c_bool() for _ in range(3)], _D()
        refs = [*map(ctypes.byref, self.flags), ctypes.byref(self.reached)]
        return self.call("DoStep", _D(t), _D(h), ctypes.c_bool(True), *refs)

    # --- Model Exchange ---------------------------------------------------------------------------------------

    def at(self, t: float, y: np.ndarray) -> None:
        assert self.call("SetTime", _D(t)) == OK
        array = np.ascontiguousarray(y, dtype=float)
        assert self.call("SetContinuousStates", array.ctypes.data_as(_P), _S(len(array))) == OK

    def _vector(self, name2: str, size: int, name3: str = "") -> np.ndarray:
        out = np.zeros(size)
        assert self.call(name2, out.ctypes.data_as(_P), _S(size), name3=name3) == OK, self.log
        return out

    def y(self) -> np.ndarray:
        return self._vector("GetContinuousStates", len(self.fmu.states))

    def rates(self) -> np.ndarray:
        return self._vector("GetDerivatives", len(self.fmu.states), "GetContinuousStateDerivatives")

    def edges(self) -> np.ndarray:
        return self._vector("GetEventIndicators", self.fmu.indicators)

    def event(self) -> bool:
        """Pass through event mode once."""
        assert self.call("EnterEventMode") == OK
        jumped = self.update()
        assert self.call("EnterContinuousTimeMode") == OK
        return jumped

    # --- state and derivatives --------------------------------------------------------------------------------

    def keep(self, state: ctypes.c_void_p | None = None) -> ctypes.c_void_p:
        state = state or _P()
        assert self.call("GetFMUstate", ctypes.byref(state), name3="GetFMUState") == OK
        return state

    def restore(self, state: ctypes.c_void_p) -> None:
        assert self.call("SetFMUstate", state, name3="SetFMUState") == OK

    def drop(self, state: ctypes.c_void_p) -> None:
        assert self.call("FreeFMUstate", ctypes.byref(state), name3="FreeFMUState") == OK

    def to_bytes(self, state: ctypes.c_void_p) -> bytes:
        size = _S()
        assert self.call("SerializedFMUstateSize", state, ctypes.byref(size), name3="SerializedFMUStateSize") == OK
        out = ctypes.create_string_buffer(size.value)
        assert self.call("SerializeFMUstate", state, out, size, name3="SerializeFMUState") == OK
        return out.raw

    def from_bytes(self, data: bytes) -> tuple[int, ctypes.c_void_p]:
        state = _P()
        names = "DeSerializeFMUstate", "DeserializeFMUState"
        status = self.call(names[0], data, _S(len(data)), ctypes.byref(state), name3=names[1])
        return status, state

    def directional(self, unknown: Sequence[str], known: Sequence[str], seed: Sequence[float]) -> np.ndarray:
        return self._derivative("GetDirectionalDerivative", unknown, known, seed, len(unknown))

    def adjoint(self, unknown: Sequence[str], known: Sequence[str], seed: Sequence[float]) -> np.ndarray:
        return self._derivative("GetAdjointDerivative", unknown, known, seed, len(known))

    def _derivative(
        self, name: str, unknown: Sequence[str], known: Sequence[str], seed: Sequence[float], size: int
    ) -> np.ndarray:
        out, given = (_D * size)(), (_D * len(seed))(*seed)
        head = self._vrs(unknown), _S(len(unknown)), self._vrs(known), _S(len(known)), given
        more = (out,) if self.fmu.fmi == 2 else (_S(len(seed)), out, _S(size))
        assert self.call(name, *head, *more) == OK, self.log
        return np.array(out)

    def free(self) -> None:
        self.fmu.library["fmi2FreeInstance" if self.fmu.fmi == 2 else "fmi3FreeInstance"](_P(self.c))


Command = Callable[[float], Sequence[float]]
