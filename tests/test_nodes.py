"""Laws for every node type there is."""

import dataclasses
import math
import subprocess
import sys
from collections.abc import Iterator
from pathlib import Path
from typing import Any, Literal, get_origin

import pytest
from annotated_types import Ge, Gt, Le, Lt

from hairpipe.app.api.node_types import node_types
from hairpipe.app.api.source import read_source
from hairpipe.engine.file.overrides import nodes_of
from hairpipe.engine.file.registry import Registry
from hairpipe.engine.node.declare import File, NodeType
from hairpipe.engine.node.settings import Field, check_settings, fields_of, metadata
from hairpipe.errors import BadInput

HOME = Path(__file__).resolve().parents[1]
HEAVY = ("numba", "pxr", "h5py", "scipy", "matplotlib", "PIL")
PUBLIC, CATALOGUE = Registry().names(), node_types(experiments=True)
NAMES = CATALOGUE.names()
ANYWHERE = ({"nonsense": 1}, [[[1]]], [{"nonsense": 1}])
"""What no setting is."""
NONSENSE = {
    float: ("1", "", True, math.nan, math.inf, -math.inf, 10**400, [], [1.0]),
    int: ("1", "", True, 0.5, math.nan, math.inf, [], [1]),
    bool: ("true", 1, 0, 0.5, []),
    str: (1, 0.5, True, []),
    Path: (1, 0.5, True, []),
    Literal: ("nonsense", "", 1, True, []),
    tuple: ("nonsense", 1, True, [math.nan], [[]]),
    None: ("nonsense", 1, 0.5, True, []),
}
"""What a setting of some kind is not; None stands for a group."""


@pytest.fixture(params=NAMES)
def node(request: pytest.FixtureRequest) -> NodeType:
    """Each node type in turn."""
    return CATALOGUE.find(request.param)


def place(names: list[str]) -> str:
    return ".".join(["node", *names])


def flat(fields: tuple[Field, ...], path: tuple[str, ...] = ()) -> Iterator[tuple[tuple[str, ...], Field]]:
    """Walk settings and the fields of groups."""
    for field in fields:
        yield (*path, field.name), field
        yield from flat(field.group, (*path, field.name))


def minimal(fields: tuple[Field, ...]) -> dict[str, Any]:
    """The fewest settings that can be given: what is required, as something of its kind."""
    samples = {Path: "file.any", str: "text", int: 1, float: 1.0, tuple: []}
    return {
        f.name: minimal(f.group) if f.group else samples[get_origin(f.base) or f.base] for f in fields if f.required
    }


def with_value(fields: tuple[Field, ...], path: tuple[str, ...], value: Any) -> dict[str, Any]:
    """The fewest settings with one of them, somewhere in the groups, set to a value."""
    name, *rest = path
    if rest:
        group = next(field.group for field in fields if field.name == name)
        value = with_value(group, tuple(rest), value)
    return {**minimal(fields), name: value}


def is_refused(node: NodeType, path: tuple[str, ...], value: Any) -> bool:
    """Whether a value is refused, and the message says where."""
    try:
        check_settings(node, with_value(fields_of(node), path, value), place)
    except BadInput as fault:
        assert str(fault).startswith("node")
        return True
    return False


def beyond(field: Field) -> Iterator[float]:
    """List the nearest values outside the range of a number."""
    for bound in metadata(field.annotation):
        if isinstance(bound, Gt):
            yield bound.gt
        elif isinstance(bound, Lt):
            yield bound.lt
        elif isinstance(bound, Ge | Le):
            limit = bound.ge if isinstance(bound, Ge) else bound.le
            away = -math.inf if isinstance(bound, Ge) else math.inf
            yield limit + (1 if away > 0 else -1) if field.base is int else math.nextafter(limit, away)


def test_there_are_nodes():
    assert {"make_bust", "simulate_hair", "export_usd"} <= set(PUBLIC) < set(NAMES)


def test_graphs_outside_of_experiments_use_public_types():
    graphs = [path for path in (HOME / "graphs").rglob("*.toml") if path.parent.name != "experiments"]
    used = {table["type"] for path in graphs for table in nodes_of(read_source(path).tables).values()}
    assert used <= set(PUBLIC)


def test_its_docstring_begins_with_one_sentence(node):
    first, *rest = (node.function.__doc__ or "").strip().splitlines()
    assert first.endswith(".") and len(first) <= 120
    assert not rest or not rest[0].strip(), "an empty line follows"


def test_every_setting_is_explained(node):
    silent = [".".join(path) for path, field in flat(fields_of(node)) if not field.help]
    assert not silent


def test_its_defaults_are_allowed(node):
    fields = fields_of(node)
    settings = check_settings(node, minimal(fields), place)
    assert list(settings) == [field.name for field in fields]


def test_unknown_settings_are_refused(node):
    with pytest.raises(BadInput, match="unknown setting 'use_magic'"):
        check_settings(node, {**minimal(fields_of(node)), "use_magic": True}, place)


def test_nonsense_is_refused(node):
    for path, field in flat(fields_of(node)):
        given = field.shorthand or field
        kind = None if given.group else get_origin(given.base) or given.base
        for value in (*ANYWHERE, *NONSENSE[kind]):
            assert is_refused(node, path, value), f"{'.'.join(path)} = {value!r} is allowed"


def test_ranges_end_where_they_say(node):
    for path, field in flat(fields_of(node)):
        for value in beyond(field):
            assert is_refused(node, path, value), f"{'.'.join(path)} = {value!r} is allowed"


def test_outputs_are_files_or_frozen_values(node):
    for kind in node.outputs.values():
        assert kind is File or (dataclasses.is_dataclass(kind) and kind.__dataclass_params__.frozen)


def test_reading_a_graph_imports_nothing_heavy():
    code = "import sys, hairpipe\ntypes = hairpipe.node_types(experiments=True)"
    code += "\nfor name in types.names(): types.find(name)"
    code += f"\nprint([name for name in {HEAVY} if name in sys.modules])"
    assert subprocess.run([sys.executable, "-c", code], capture_output=True, text=True).stdout == "[]\n"
