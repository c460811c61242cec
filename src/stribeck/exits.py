"""How the program ends: every failure is one line on standard error and an exit status that says whose fault it was."""

from __future__ import annotations

import sys
import traceback
from collections.abc import Mapping, Sequence
from io import TextIOWrapper
from typing import Any

import typer

from stribeck.errors import InputError, StribeckError
from stribeck.stopping import stoppable

DONE, FAILED, WRONG_INPUT, INTERRUPTED = 0, 1, 2, 130


def guarded(command: Any, arguments: Sequence[str], several: Mapping[str, str] | None = None) -> int:
    """Run a command; return the exit status.

    Parameters
    ----------
    command : click-like command
        With ``make_context`` and ``invoke``.
    arguments : sequence of str
        ``--debug`` may stand anywhere and shows a traceback.
    several : mapping
        Options that take several values, up to the next option, and what these are.

    Returns
    -------
    int
        0 done, 2 the input or the arguments are wrong, 130 interrupted, 1 anything else.
    """
    debug = "--debug" in arguments
    arguments = [argument for argument in arguments if argument != "--debug"]
    if isinstance(sys.stdout, TextIOWrapper):  # a sign that the terminal lacks is no failure; all files are written
        sys.stdout.reconfigure(errors="replace")
    try:
        for option, values in (several or {}).items():
            arguments = spread(arguments, option, values)
        # not command.main(): it would turn Ctrl-C into an exception of its own and print an empty line
        with stoppable(), command.make_context("stribeck", arguments) as context:
            command.invoke(context)
    except typer.Exit as stop:
        return int(stop.exit_code)
    except (KeyboardInterrupt, typer.Abort):
        _say("interrupted; nothing was written")
        return INTERRUPTED
    except Exception as error:
        if debug:
            traceback.print_exc()
        return _explain(error)
    return DONE


def spread(arguments: Sequence[str], option: str, values: str = "values") -> list[str]:
    """Repeat an option before each of the values that follow it, up to the next option.

    ``--held-out a b`` becomes ``--held-out a --held-out b``: the parser takes one value an option. Raises `InputError`
    where none follows: the parser would take the next option for it. ``values`` says what they are.
    """
    result: list[str] = []
    after = False  # whether the option's first value has been passed
    spreading = False
    for argument in arguments:
        if argument.startswith("-"):
            if spreading and not after:
                raise InputError(f"{option} needs {values}", argument, f"give some between {option} and {argument}")
            name, equals, _ = argument.partition("=")
            spreading, after = name == option, bool(equals)
        elif spreading and after:
            result.append(option)
        else:
            after = True
        result.append(argument)
    return result


def _explain(error: Exception) -> int:
    if isinstance(error, InputError):
        _say(str(error))
        return WRONG_INPUT
    if hasattr(error, "format_message"):  # the parser's own errors, whichever package they come from
        context = getattr(error, "ctx", None)
        _say(f"{error.format_message().rstrip('.')}; see {context.command_path if context else 'stribeck'} --help")
        return WRONG_INPUT
    if isinstance(error, StribeckError):
        _say(str(error))
    else:
        _say(f"{type(error).__name__}: {error} (add --debug for a traceback)")
    return FAILED


def _say(text: str) -> None:
    print("stribeck:", " ".join(text.split()), file=sys.stderr)
