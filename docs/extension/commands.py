"""`{commands}`: the commands of `hairpipe`, with arguments and options, as click has them."""

import inspect
from collections.abc import Iterator
from typing import Any

from sphinx.application import Sphinx

from extension.markdown import MarkdownDirective, docstring, escaped, fence, joined, table
from hairpipe.app.cli.entry import commands


class Commands(MarkdownDirective):
    """All commands, in the order in which `hairpipe --help` lists them."""

    def write(self) -> str:
        """Describe every command."""
        top = commands.make_context("hairpipe", [], resilient_parsing=True)
        return joined(describe(context) for context in contexts_below(top))


def contexts_below(context: Any) -> Iterator[Any]:
    """List the contexts of the commands below one, each before those below it."""
    for name in getattr(context.command, "list_commands", lambda _: [])(context):
        inner = context.command.get_command(context, name)
        below = inner.make_context(name, [], parent=context, resilient_parsing=True)
        yield below
        yield from contexts_below(below)


def describe(context: Any) -> str:
    """Describe a command, below a heading of its name."""
    records = [found for each in context.command.get_params(context) if (found := each.get_help_record(context))]
    level = "#" * len(context.command_path.split())
    return joined(
        [
            f"{level} {context.command_path}",
            fence("none", context.command.get_usage(context).removeprefix("Usage: ")),
            docstring(inspect.cleandoc(context.command.help or "").replace("\b", "")),
            table(["option", "meaning"], [[f"`{name}`", escaped(words)] for name, words in records if words]),
        ]
    )


def setup(app: Sphinx) -> dict[str, bool]:
    """Add the directive."""
    app.add_directive("commands", Commands)
    return {"parallel_read_safe": True, "parallel_write_safe": True}
