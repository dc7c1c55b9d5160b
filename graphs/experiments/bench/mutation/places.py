"""Places of a source file where a mutation can change what the code does, and one mutation for each.

The operators are those of Cosmic Ray, without two that exchange names of variables, and two more: a statement is left
out, and None is returned. A place is a part of the source and a kind of operator. Eleven operators can replace an
addition: one of them is drawn, as a score would count the addition eleven times otherwise.

Left out are mutations of annotations, messages of exceptions, caches and options of the compiler, which change nothing
that is promised.
"""

import ast
import random
from collections import defaultdict
from collections.abc import Iterable, Iterator
from functools import cache
from typing import Any, NamedTuple

import parso.python.tree as syntax
from cosmic_ray.ast import ast_nodes, get_ast
from cosmic_ray.mutating import mutate_code
from cosmic_ray.operators.operator import Example, Operator
from cosmic_ray.plugins import get_operator, operator_names

SAVING = ("@cache", "@inlined", "@njit")
"""Decorators that save time and change no result."""
NAMES_OF_VARIABLES = ("VariableReplacer", "VariableInserter")
"""Operators that draw by themselves, so that no seed repeats what they do."""

Span = tuple[tuple[int, int], tuple[int, int]]
"""First line and column, and those behind the last."""


class LeaveOut(Operator):
    """Leave out a statement: a call, a deletion, an exception that is raised, an addition in place."""

    def mutation_positions(self, node: Any) -> Any:
        """Find the statement."""
        if node.type == "simple_stmt":
            first = node.children[0]
            is_call = first.type == "atom_expr" and first.children[-1].type == "trailer"
            in_place = first.type == "expr_stmt" and getattr(first.children[1], "value", "=")[:-1]
            if is_call or in_place or first.type in ("raise_stmt", "del_stmt"):
                yield first.start_pos, first.end_pos

    def mutate(self, node: Any, index: int) -> Any:
        """Put `pass` in its place."""
        first = node.children[0]
        node.children[0] = syntax.Keyword("pass", first.start_pos, first.get_first_leaf().prefix)
        return node

    @classmethod
    def examples(cls) -> Any:
        """Give an example."""
        return (Example("flush(path)\n", "pass\n"),)


class ReturnNone(Operator):
    """Return None in place of a value."""

    def mutation_positions(self, node: Any) -> Any:
        """Find the value."""
        if node.type == "return_stmt" and getattr(node.children[1], "value", "") != "None":
            yield node.children[1].start_pos, node.children[1].end_pos

    def mutate(self, node: Any, index: int) -> Any:
        """Put None in its place."""
        node.children[1] = syntax.Keyword("None", node.children[1].start_pos, " ")
        return node

    @classmethod
    def examples(cls) -> Any:
        """Give an example."""
        return (Example("def f(): return 1", "def f(): return None"),)


OWN = {operator.__name__: operator for operator in (LeaveOut, ReturnNone)}


class Mutant(NamedTuple):
    """A change of a source file.

    operator    that makes it
    occurrence  of the operator, counted through the file
    span        what is changed
    """

    operator: str
    occurrence: int
    span: Span

    @property
    def kind(self) -> str:
        """Operators that change the same have one."""
        return self.operator.rpartition("/")[2].partition("_")[0]

    def applied(self, source: str) -> str | None:
        """Return the changed source; None where nothing is changed."""
        return mutate_code(source, make_operator(self.operator), self.occurrence)


@cache
def make_operator(name: str) -> Operator:
    """Make an operator: one of ours, or Cosmic Ray's."""
    return OWN[name]() if name in OWN else get_operator(name)()


def draw_places(source: str, draw: random.Random) -> list[list[Mutant]]:
    """List the places of a source file in their order, each with its mutations in an order that is drawn."""
    silent = silent_spans(source)
    lines = source.splitlines()
    places: dict[tuple[Span, str], list[Mutant]] = defaultdict(list)
    for mutant in mutants_of(source):
        is_silent = any(begin <= mutant.span[0] and mutant.span[1] <= end for begin, end in silent)
        if not is_silent and lines[mutant.span[0][0] - 1].strip() not in SAVING:
            places[mutant.span, mutant.kind].append(mutant)
    drawn = [mutants for _, mutants in sorted(places.items())]
    for mutants in drawn:
        draw.shuffle(mutants)
    return drawn


def changed_source(source: str, mutants: Iterable[Mutant]) -> str | None:
    """Apply the first of some mutations that gives other Python; None where none does."""
    changed = (mutant.applied(source) or source for mutant in mutants)
    return next((text for text in changed if meaning_of(text) not in ("", meaning_of(source))), None)


def mutants_of(source: str) -> Iterator[Mutant]:
    """List all mutations of a source file."""
    tree = get_ast(source)
    names = [name for name in operator_names() if not name.endswith(NAMES_OF_VARIABLES)]
    for name in (*names, *OWN):
        operator: Any = make_operator(name)
        occurrence = 0
        for node in ast_nodes(tree):
            for span in operator.mutation_positions(node):
                yield Mutant(name, occurrence, span)
                occurrence += 1


def meaning_of(source: str) -> str:
    """Write the syntax tree of a source file; empty for no Python."""
    try:
        return ast.dump(ast.parse(source))
    except SyntaxError:
        return ""


def silent_spans(source: str) -> list[Span]:
    """List the parts that do not act: annotations, what exceptions are raised with, and options of the compiler."""
    found: list[ast.expr | ast.keyword | None] = []
    for item in ast.walk(ast.parse(source)):
        if isinstance(item, ast.Raise) and isinstance(item.exc, ast.Call):
            found += [*item.exc.args, *item.exc.keywords]
        found += [item.annotation] if isinstance(item, ast.arg | ast.AnnAssign) else []
        if isinstance(item, ast.FunctionDef):
            compiling = [each for each in item.decorator_list if "njit" in ast.unparse(each)]
            found += [item.returns, *compiling]
    return [((e.lineno, e.col_offset), (e.end_lineno or 0, e.end_col_offset or 0)) for e in found if e is not None]
