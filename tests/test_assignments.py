"""Unlike things are assigned one by one, and many values together have names."""

import ast
from collections.abc import Iterator

from .sources import SOURCES, name_of, tree_of
from .test_architecture import functions_of, is_compiled, parameters_of

MOST_WITHOUT_NAMES = 4
"""Values of a tuple that a function of the wheel takes or returns; compiled ones may unpack blocks of matrices."""


def form_of(value: ast.expr) -> object:
    """Describe an expression without its names and numbers: `a.x` is like `b.y`, `f(1)` like `f(2)`."""
    if isinstance(value, ast.Name | ast.Constant):
        return type(value)
    if isinstance(value, ast.UnaryOp) and isinstance(value.operand, ast.Constant):
        return ast.Constant
    if isinstance(value, ast.Call):
        named = [(keyword.arg, form_of(keyword.value)) for keyword in value.keywords]
        return (ast.dump(value.func), tuple(map(form_of, value.args)), tuple(named))
    parts = ast.iter_child_nodes(value)
    return (type(value), *(form_of(part) if isinstance(part, ast.expr) else type(part) for part in parts))


def names_in(expression: ast.expr) -> set[str]:
    return {item.id for item in ast.walk(expression) if isinstance(item, ast.Name)}


def is_exchange(targets: list[ast.expr], values: list[ast.expr]) -> bool:
    """Whether a value is read after the name that it reads would have been assigned, as in `a, b = b, a`."""
    return any(names_in(target) & names_in(value) for k, target in enumerate(targets) for value in values[k + 1 :])


def assignments_of_unlike_things(tree: ast.Module) -> Iterator[ast.Assign]:
    for item in ast.walk(tree):
        if not isinstance(item, ast.Assign) or not isinstance(item.value, ast.Tuple):
            continue
        target, values = item.targets[0], item.value.elts
        if isinstance(target, ast.Tuple) and len(target.elts) == len(values) and len(item.targets) == 1:
            named = all(isinstance(each, ast.Name) for each in target.elts)
            alike = len(set(map(form_of, values))) == 1
            if named and not alike and not is_exchange(target.elts, values):
                yield item


def test_unlike_things_are_assigned_one_by_one():
    wrong = [
        f"{name_of(path)}:{item.lineno}: {ast.unparse(item)}"
        for path in SOURCES
        for item in assignments_of_unlike_things(tree_of(path))
    ]
    assert not wrong, "\n".join(wrong)


def test_like_values_and_swaps_may_share_a_line():
    text = "a, b = x.p, y.q\nc, d = d, c + 1\ne, f = 0, len(g)\ns, t = s + 1, s\n"
    assert [item.lineno for item in assignments_of_unlike_things(ast.parse(text))] == [3]


def is_long(value: ast.expr | None) -> bool:
    return isinstance(value, ast.Tuple) and len(value.elts) > MOST_WITHOUT_NAMES


def is_long_type(annotation: ast.expr | None) -> bool:
    """Whether a type has a tuple of many values in it, each with a type of its own."""
    parts = ast.walk(annotation) if annotation else ()
    found = (part.slice for part in parts if isinstance(part, ast.Subscript) and ast.unparse(part.value) == "tuple")
    return any(map(is_long, found))


def takes_or_returns_a_long_tuple(function: ast.FunctionDef) -> bool:
    types = [function.returns, *(parameter.annotation for parameter in parameters_of(function))]
    returned = [item.value for item in ast.walk(function) if isinstance(item, ast.Return)]
    called = [item for item in ast.walk(function) if isinstance(item, ast.Assign) and isinstance(item.value, ast.Call)]
    return any([*map(is_long_type, types), *map(is_long, returned), *(is_long(item.targets[0]) for item in called)])


def test_many_values_are_a_record():
    wrong = [
        f"{name_of(path)}:{function.lineno} {function.name}"
        for path in SOURCES
        if name_of(path).startswith(("hairpipe/", "nodes/"))
        for function in functions_of(tree_of(path))
        if not is_compiled(function) and takes_or_returns_a_long_tuple(function)
    ]
    assert not wrong, "\n".join(wrong)


def test_a_long_tuple_is_found_wherever_a_function_takes_or_returns_it():
    for text in (
        "def f(a: list[tuple[int, int, int, int, int]]) -> None: ...",
        "def f() -> tuple[int, int, int, int, int] | None: ...",
        "def f(): return 1, 2, 3, 4, 5",
        "def f(): a, b, c, d, e = g()",
    ):
        assert takes_or_returns_a_long_tuple(next(functions_of(ast.parse(text)))), text
    short = "def f(a: tuple[int, ...]) -> tuple[int, int, int, int]: a, b, c, d = g(); return a, b, c, d"
    assert not takes_or_returns_a_long_tuple(next(functions_of(ast.parse(short))))
