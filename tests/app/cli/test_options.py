"""What the help of a command names, the command takes: checked over the whole tree of commands."""

import inspect
import re
from collections.abc import Iterator

import click
import pytest

from hairpipe.app.cli.entry import commands

OPTION = re.compile(r"(?<![\w-])--?[a-z][a-z-]*")


def commands_below(group: click.Group, path: str = "hairpipe") -> Iterator[tuple[str, click.Command]]:
    """List all commands that are not groups, each with its path."""
    context = click.Context(group)
    for name in group.list_commands(context):
        command = group.get_command(context, name)
        assert command is not None
        if isinstance(command, click.Group):
            yield from commands_below(command, f"{path} {name}")
        else:
            yield f"{path} {name}", command


SHOT = {"graph", "overrides", "cache"}
ENGINE = {"jobs", "engine", "scheduler", "insecure"}
COMMANDS = dict(commands_below(commands))


@pytest.mark.parametrize("path", COMMANDS)
def test_the_function_of_a_command_takes_its_options_and_nothing_else(path):
    command = COMMANDS[path]
    assert command.callback is not None
    declared = {param.name for param in command.params if param.expose_value}
    taken = set(inspect.signature(inspect.unwrap(command.callback)).parameters)
    if declared >= ENGINE:  # these are one argument
        declared -= ENGINE - {"engine"}
    if "shot" in taken:
        declared = declared - SHOT | {"shot"}
        taken |= {"wedge"} & declared  # of which a command gets the shot of all variants
    assert declared == taken


@pytest.mark.parametrize("path", COMMANDS)
def test_help_names_no_option_that_the_command_refuses(path):
    command = COMMANDS[path]
    taken = {text for param in command.params for text in [*param.opts, *param.secondary_opts]} | {"--help"}
    texts = [
        command.help or "",
        command.epilog or "",
        *(getattr(param, "help", None) or "" for param in command.params),
    ]
    assert not {option for text in texts for option in OPTION.findall(text)} - taken
