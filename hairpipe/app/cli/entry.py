"""`hairpipe`: find the command, and report a fault in one message."""

import importlib
import io
import os
import signal
import sys
from contextlib import suppress
from typing import Any

import click
from click.shell_completion import add_completion_class

from hairpipe import __version__
from hairpipe.app.cli.completion import Bash
from hairpipe.app.cli.options import EXPERIMENTS, check_experiments, has_experiments
from hairpipe.app.cli.stderr import ClosedPipe, fail, open_stderr
from hairpipe.child import search_path
from hairpipe.cli import leave
from hairpipe.engine.node.messages import nearest, one_line
from hairpipe.errors import BadInput

CHECKOUT = {"validate": "commands.validate", "results": "commands.results", "bench": "bench.commands"}
"""Modules of experiments, which a wheel is without, by the command that each defines."""
COMMANDS = (
    *("run", "plan", "watch", "view", "report", "explain", "graph", "nodes", "get", "bridge", "blender", "convert"),
    *("tune", "validate", "wedge", "farm", "results"),
    *("cache", "warm", "trust", "usd", "data", "bench", "version"),
)
"""In the order of their use."""
MODULES = {
    "run": ("run", "warm", "farm"),
    "results": ("plan", "watch", "explain", "get"),
    "page": ("view", "report"),
    "graph": ("graph", "nodes"),
    "files": ("bridge", "blender", "convert", "usd"),
    "environment": ("trust", "data", "version"),
}
"""Modules that define several commands; each other command has one of its name."""
BAD_INPUT, INTERRUPTED, BROKEN_PIPE = 2, 130, 141
COMPLETION = 'Shell completion: eval "$(_HAIRPIPE_COMPLETE=bash_source hairpipe)"; zsh and fish work the same way.'


class Group(click.Group):
    """Commands that report bad input in one message, with an exit code."""

    def invoke(self, ctx: click.Context) -> Any:
        if signal.getsignal(signal.SIGINT) is leave:
            signal.signal(signal.SIGINT, signal.default_int_handler)
        try:
            super().invoke(ctx)
            if sys.stdout is not None:
                sys.stdout.flush()
        except click.UsageError as fault:
            raise click.UsageError(one_line(fault.format_message()), fault.ctx) from None
        except BadInput as fault:
            fail(str(fault), BAD_INPUT)
        except (BrokenPipeError, ClosedPipe):
            close_output()
            sys.exit(BROKEN_PIPE)
        except OSError as fault:
            close_output()
            fail(": ".join(filter(None, [fault.filename, fault.strerror or str(fault)])), BAD_INPUT)
        except (KeyboardInterrupt, click.Abort):
            fail("interrupted", INTERRUPTED)


class Commands(Group):
    """Commands by name, imported when they are called, so that the start is fast."""

    def list_commands(self, ctx: click.Context) -> list[str]:
        return [name for name in COMMANDS if name not in CHECKOUT or has_experiments()]

    def get_command(self, ctx: click.Context, cmd_name: str) -> click.Command | None:
        if cmd_name not in COMMANDS:
            return None
        if cmd_name in CHECKOUT:
            if not has_experiments() and ctx.resilient_parsing:
                return None  # nothing to complete
            check_experiments(f"hairpipe {cmd_name}")
            return getattr(importlib.import_module(f"{EXPERIMENTS}.{CHECKOUT[cmd_name]}"), cmd_name)
        module = next((module for module, names in MODULES.items() if cmd_name in names), cmd_name)
        return getattr(importlib.import_module(f"hairpipe.app.cli.commands.{module}"), cmd_name)

    def resolve_command(
        self, ctx: click.Context, args: list[str]
    ) -> tuple[str | None, click.Command | None, list[str]]:
        """Find the command of the arguments; for an unknown one, suggest the nearest."""
        if not args[0].startswith("-") and args[0] not in COMMANDS and not ctx.resilient_parsing:
            ctx.fail(f"no command '{args[0]}' ({nearest(args[0], list(COMMANDS))})")
        return super().resolve_command(ctx, args)


def close_output() -> None:
    """Discard unwritten output, so that Python does not report it at exit."""
    with suppress(AttributeError, OSError):  # there may be no output, or none with a descriptor
        os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())


@click.command(cls=Commands, epilog=COMPLETION)
@click.version_option(__version__, prog_name="hairpipe", message="%(prog)s %(version)s")
def commands() -> None:
    """Hair that follows a body: graph file in, USD curves and OpenVDB level sets out.

    A run computes only what has changed since the last one, down to the frame.
    """


def main() -> None:
    """Run the command line of this process."""
    start(commands, "hairpipe")


def start(command: click.Command, name: str) -> None:
    """Run a command under a name, on the arguments of this process."""
    sys.path[:] = search_path()
    open_stderr()
    for stream in (sys.stdout, sys.stderr):
        if isinstance(stream, io.TextIOWrapper):
            stream.reconfigure(errors="backslashreplace")  # a file name may be invalid text
    add_completion_class(Bash)
    command(prog_name=name)
