"""Every public name is documented, with the arguments that it has; the sources are read, not imported."""

import ast
import builtins
import re
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

import pytest

SOURCE = Path(__file__).parents[1] / "src"
MANY = 5  # arguments: one line does not tell so many
HEADING = re.compile(r"^(\w[\w ]*)\n-{3,}$", re.MULTILINE)

Function = ast.FunctionDef | ast.AsyncFunctionDef


@dataclass(frozen=True)
class Found:
    """A function, method or class of a file; `owner` is the class it is in."""

    path: str
    node: Function | ast.ClassDef
    owner: ast.ClassDef | None = None

    @property
    def public(self) -> bool:
        parts = [*self.path.removesuffix(".py").removesuffix("/__init__").split("/"), self.node.name]
        return not any(part.startswith("_") for part in [*parts, *([self.owner.name] if self.owner else [])])

    @property
    def words(self) -> str:
        return ast.get_docstring(self.node) or ""

    def fault(self, what: str) -> str:
        name = f"{self.owner.name}.{self.node.name}" if self.owner else self.node.name
        return f"{self.path}:{self.node.lineno}: {name}: {what}"


class Sources:
    """Files, each a text by its path, and what they define."""

    def __init__(self, texts: dict[str, str]) -> None:
        self.found: list[Found] = []
        self.helped: set[str] = set()  # annotations that bring their help, by the name they are given
        for path, text in texts.items():
            tree = ast.parse(text)
            self.found += _found(path, tree.body, None)
            for node in tree.body:
                if isinstance(node, ast.Assign) and has_help(node.value):
                    self.helped |= {ast.unparse(target) for target in node.targets}
        self.classes: dict[str, list[ast.ClassDef]] = {}
        for each in self.found:
            if isinstance(each.node, ast.ClassDef):
                self.classes.setdefault(each.node.name, []).append(each.node)

    def bases(self, node: ast.ClassDef) -> Iterator[ast.ClassDef]:
        """Give all classes of these files from which one inherits."""
        for name in map(ast.unparse, node.bases):
            for base in self.classes.get(name, []):
                yield base
                yield from self.bases(base)

    def overrides(self, found: Found) -> bool:
        """Return whether a method is documented in a base of its class."""
        bodies = [base.body for base in self.bases(found.owner)] if found.owner else []
        return any(
            isinstance(node, Function) and node.name == found.node.name and ast.get_docstring(node)
            for body in bodies
            for node in body
        )

    def is_error(self, name: str) -> bool:
        """Return whether there is an exception of that name, of Python or of these files."""
        known = getattr(builtins, name, None)
        if isinstance(known, type):
            return issubclass(known, BaseException)
        return any(self.is_error(ast.unparse(base)) for node in self.classes.get(name, []) for base in node.bases)

    def faults(self) -> list[str]:
        """Return what is wrong, a line each: where it is, its name, and what it is."""
        return [each.fault(what) for each in self.found for what in self._faults(each)]

    def _faults(self, each: Found) -> Iterator[str]:
        if each.public and not each.words and not self.overrides(each):
            yield "no docstring"
        if isinstance(each.node, ast.ClassDef):
            yield from class_faults(each.node)
        elif is_command(each.node):
            yield from (f"no help for {name}" for name in unhelped(each.node, self.helped))
        else:
            yield from function_faults(each)
        for name in entries(each.words, "Raises"):
            if not self.is_error(name):
                yield f"{name} is no exception"


def _found(path: str, body: list[ast.stmt], owner: ast.ClassDef | None) -> Iterator[Found]:
    for node in body:
        if isinstance(node, ast.ClassDef):
            yield Found(path, node, owner)
            yield from _found(path, node.body, node)
        elif isinstance(node, Function) and not {"overload", "setter"} & set(decorators(node)):
            yield Found(path, node, owner)


def function_faults(each: Found) -> Iterator[str]:
    """Give what is wrong with the arguments that a function documents."""
    given, told = arguments(each.node), entries(each.words, "Parameters")
    if told:
        yield from differences(told, given)
    elif each.public and each.words and len(given) >= MANY:
        yield f"{len(given)} arguments and no Parameters"


def class_faults(node: ast.ClassDef) -> Iterator[str]:
    """Give what is wrong with the arguments that a class documents: of ``__init__``, or its fields.

    Fields may stand among the attributes, where properties may stand, too, or each have a text of its own below it.
    """
    words = ast.get_docstring(node) or ""
    told, attributes = entries(words, "Parameters"), entries(words, "Attributes")
    init = next((each for each in node.body if isinstance(each, Function) and each.name == "__init__"), None)
    if init is not None:
        given = arguments(init)
        if told:
            yield from differences(told, given)
        elif not node.name.startswith("_") and len(given) >= MANY:
            yield f"{len(given)} arguments and no Parameters"
    elif has_fields(node) and (told or attributes):
        extra = {each.name for each in node.body if isinstance(each, Function)}
        yield from differences([each for each in told + attributes if each not in extra], fields(node))
    elif told:
        yield "Parameters without __init__ or fields"


def differences(told: list[str], given: list[str]) -> Iterator[str]:
    """Give which arguments are not told, and what is told that is none."""
    yield from (f"{name} is not documented" for name in given if name not in told)
    yield from (f"{name} is documented, but no argument" for name in told if name not in given)
    yield from (f"{name} is documented twice" for name in sorted(set(told)) if told.count(name) > 1)


def entries(words: str, section: str) -> list[str]:
    """Return the names that a section of a numpydoc text explains."""
    texts = HEADING.split(words)
    lines = [line for k in range(1, len(texts), 2) if texts[k] == section for line in texts[k + 1].splitlines()]
    heads = [line.split(" : ")[0] for line in lines if line and not line[0].isspace()]
    return [name.strip() for head in heads for name in head.split(",")]


def arguments(node: Function) -> list[str]:
    """Return the names of the arguments, ``self`` apart, stars with them."""
    of = node.args
    names = [each.arg for each in (*of.posonlyargs, *of.args)]
    names = names[1:] if names[:1] in (["self"], ["cls"]) else names
    names += [f"*{of.vararg.arg}"] if of.vararg else []
    names += [each.arg for each in of.kwonlyargs]
    return names + ([f"**{of.kwarg.arg}"] if of.kwarg else [])


def has_fields(node: ast.ClassDef) -> bool:
    return "dataclass" in decorators(node) or "NamedTuple" in map(ast.unparse, node.bases)


def fields(node: ast.ClassDef) -> list[str]:
    """Return the fields of a class that have no text of their own below them."""
    follows = [*node.body[1:], None]
    return [
        ast.unparse(each.target)
        for each, after in zip(node.body, follows, strict=True)
        if isinstance(each, ast.AnnAssign)
        and not ast.unparse(each.annotation).startswith("ClassVar")
        and not (isinstance(after, ast.Expr) and isinstance(after.value, ast.Constant))
    ]


def decorators(node: Function | ast.ClassDef) -> list[str]:
    """Return the last word of each: ``command`` of ``@app.command(epilog="")``."""
    called = [each.func if isinstance(each, ast.Call) else each for each in node.decorator_list]
    return [ast.unparse(each).split(".")[-1] for each in called]


def is_command(node: Function) -> bool:
    """Return whether typer calls the function, and prints its help."""
    return bool({"command", "callback"} & set(decorators(node)))


def has_help(annotation: ast.expr | None) -> bool:
    """Return whether an ``Annotated`` tells typer a text."""
    inside = ast.walk(annotation) if annotation else ()
    keywords = [word for each in inside if isinstance(each, ast.Call) for word in each.keywords]
    return any(word.arg == "help" and isinstance(word.value, ast.Constant) and word.value.value for word in keywords)


def unhelped(node: Function, helped: set[str]) -> Iterator[str]:
    """Give the arguments of a command without help; that of the context is typer's own."""
    for each in (*node.args.args, *node.args.kwonlyargs):
        kind = ast.unparse(each.annotation) if each.annotation else ""
        if kind not in (*helped, "typer.Context") and not has_help(each.annotation):
            yield each.arg


def test_every_public_name_is_documented_with_its_arguments() -> None:
    texts = {str(path.relative_to(SOURCE)): path.read_text(encoding="utf-8") for path in SOURCE.rglob("*.py")}
    sources = Sources(dict(sorted(texts.items())))
    assert len(sources.found) > 1000
    assert "\n".join(sources.faults()) == ""


DOCUMENTED = '''
def moved(q, *runs, rate=1.0):
    """Return it.

    Parameters
    ----------
    q : array (N, n)
        Positions, rad.
    *runs : Run
    rate : float
        Hz.

    Raises
    ------
    ValueError
        When it is not.
    """


@dataclass(frozen=True)
class Move:
    """A move.

    Attributes
    ----------
    start, end : float
        rad.
    """

    start: float
    end: float
    speed: float = 0.0
    """In rad/s."""


class Plant:
    """What moves.

    Parameters
    ----------
    arm : Arm
    """

    def __init__(self, arm):
        self.arm = arm

    def step(self, time):
        """Go on."""


class Robot(Plant):
    """Another one."""

    def step(self, time):
        pass
'''


def told(text: str) -> list[str]:
    """Return the faults of a module."""
    return [fault.split(": ", 1)[1] for fault in Sources({"package/module.py": text}).faults()]


def test_what_is_documented_has_no_faults() -> None:
    assert told(DOCUMENTED) == []


@pytest.mark.parametrize(
    ("old", "new", "faults"),
    [
        ("    q : array (N, n)\n        Positions, rad.\n", "", ["moved: q is not documented"]),
        ("moved(q, ", "moved(", ["moved: q is documented, but no argument"]),
        ("moved(q, ", "moved(p, ", ["moved: p is not documented", "moved: q is documented, but no argument"]),
        ("    rate : float", "    q : array\n    rate : float", ["moved: q is documented twice"]),
        ("    *runs :", "    runs :", ["moved: *runs is not documented", "moved: runs is documented, but no argument"]),
        ("ValueError", "ValueMistake", ["moved: ValueMistake is no exception"]),
        ("ValueError", "Move", ["moved: Move is no exception"]),
        ("start, end : float", "start : float", ["Move: end is not documented"]),
        ('    """In rad/s."""', "", ["Move: speed is not documented"]),
        ("arm):", "arm, step):", ["Plant: step is not documented"]),
        ('        """Go on."""', "        pass", ["Plant.step: no docstring", "Robot.step: no docstring"]),
        ('    """Another one."""', "", ["Robot: no docstring"]),
    ],
)
def test_a_fault_is_noticed(old: str, new: str, faults: list[str]) -> None:
    assert DOCUMENTED.count(old) == 1
    assert told(DOCUMENTED.replace(old, new)) == faults


def test_many_arguments_need_a_section() -> None:
    text = 'def f({}):\n    """Do it."""\n\n\nclass C:\n    """It."""\n\n    def __init__(self, {}):\n        pass\n'
    assert told(text.format("a, b, c, d", "a, b, c, d")) == []
    what = "5 arguments and no Parameters"
    assert told(text.format("a, b, c, *, d=0, e=0", "a, b, c, d, e")) == [f"f: {what}", f"C: {what}"]


def test_what_is_private_needs_no_words_but_true_ones() -> None:
    assert told("def _f(a, b, c, d, e):\n    pass\n") == []
    assert told('def _f(a):\n    """Do it.\n\n    Parameters\n    ----------\n    b : int\n    """\n') == [
        "_f: a is not documented",
        "_f: b is documented, but no argument",
    ]


def test_a_command_needs_help_for_each_argument() -> None:
    text = (
        'Out = Annotated[Path, typer.Option(help="New folder.")]\n\n\n@app.command(epilog="")\n'
        'def run(out: Out, seed: Annotated[int, typer.Option({})] = 0) -> None:\n    """Run."""\n'
    )
    assert told(text.format('help="Of the noise."')) == []
    assert told(text.format("min=0")) == ["run: no help for seed"]


def test_a_fault_says_where() -> None:
    assert Sources({"package/module.py": "\n\ndef f():\n    pass\n"}).faults() == [
        "package/module.py:3: f: no docstring"
    ]
