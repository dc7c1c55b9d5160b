"""`{results} NAME`: tables and figures that commands of this repository have measured, as their records have them."""

from functools import cache
from pathlib import Path
from typing import Any, ClassVar

from docutils import nodes
from docutils.parsers.rst import directives
from sphinx.application import Sphinx
from sphinx.util.docutils import SphinxRole

from extension.markdown import MarkdownDirective
from hairpipe.errors import BadInput
from hairpipe.graphs.experiments.figures.pages import figure_of, markdown_of
from hairpipe.graphs.experiments.figures.recipe import state_of


@cache
def word_of(path: Path) -> str:
    """Return the word for the state of results, which takes a while to find."""
    return state_of(path).word


class Results(MarkdownDirective):
    """A table with references to results in place of figures."""

    option_spec: ClassVar = {"where": directives.unchanged}

    def write(self) -> str:
        """Look the figures up."""
        [name] = self.arguments
        try:
            return markdown_of(name, self.content, self.options.get("where", ""), word_of)
        except BadInput as fault:
            raise self.error(str(fault)) from None


class Figure(SphinxRole):
    """A figure within a line: name of the results, and a reference."""

    def run(self) -> tuple[list[nodes.Node], list[Any]]:
        """Look the figure up."""
        name, brace, reference = self.text.partition("{")
        try:
            return [nodes.Text(figure_of(name.strip(), brace + reference, word_of))], []
        except BadInput as fault:
            message = self.inliner.reporter.error(str(fault), line=self.lineno)
            return [self.inliner.problematic(self.rawtext, self.rawtext, message)], [message]


def setup(app: Sphinx) -> dict[str, bool]:
    """Add the directive and the role."""
    app.add_directive("results", Results)
    app.add_role("results", Figure())
    return {"parallel_read_safe": True, "parallel_write_safe": True}
