"""`@node`: a typed pure function is a node, and its signature says everything the engine needs to know."""

import inspect
import re
import types
from collections.abc import Callable, Iterable
from dataclasses import dataclass
from typing import Any, Literal, NoReturn, TypeVar, Union, get_args, get_origin, get_type_hints

from hairpipe.errors import BadInput
from hairpipe.graph.node.files import Workspace
from hairpipe.graph.node.frames import Frames, Pair, Reached, Time

Mode = Literal["once", "each", "scan"]
View = Literal["now", "pair", "frames", "reached"]
Function = TypeVar("Function", bound=Callable[..., Any])

RESERVED = frozenset({"type", "in", "publish", "checkpoint", "like", "without"})
SINGLE = ""
"""Name of the output of a node that has only one."""


@dataclass(frozen=True)
class Socket:
    """An input of a node: which type of value, how much of time it sees, and whether it may stay unconnected.

    many  whether it takes a list of edges; each is plugged in under a name of its own, as `tables.0`, `tables.1`
    """

    name: str
    type: type
    view: View
    optional: bool
    many: bool

    def plugs(self, connected: Iterable[str]) -> tuple[str, ...]:
        """Names under which its edges are plugged in, in order: its own, or those of the connected that are its."""
        return tuple(plug for plug in connected if plug.partition(".")[0] == self.name) if self.many else (self.name,)


@dataclass(frozen=True)
class SettingField:
    """A keyword-only parameter as declared; `default` is `inspect.Parameter.empty` where there is none."""

    name: str
    annotation: Any
    default: Any


@dataclass(frozen=True, eq=False)
class NodeType:
    """All that a signature declares.

    returns         as declared, a NamedTuple where there are several outputs
    state           output that a scan receives back as `previous`
    asks_time       names of its parameters that take the time, and
    asks_workspace  a folder to write in
    """

    name: str
    mode: Mode
    function: Callable[..., Any]
    sockets: dict[str, Socket]
    settings: dict[str, SettingField]
    outputs: dict[str, type]
    returns: type
    state: str | None
    asks_time: tuple[str, ...]
    asks_workspace: tuple[str, ...]

    def socket(self, plug: str) -> Socket:
        """Find the socket that an edge is plugged into."""
        return self.sockets[plug.partition(".")[0]]

    def by_output(self, result: Any) -> dict[str, Any]:
        """Name the outputs in what a call returned; TypeError where it is not of the declared type."""
        if not isinstance(result, self.returns):
            raise TypeError(f"returned a {type(result).__name__}, declared {self.returns.__name__}")
        return {SINGLE: result} if SINGLE in self.outputs else result._asdict()

    @property
    def module(self) -> str:
        """Name of the module that declares it."""
        return self.function.__module__

    @property
    def summary(self) -> str:
        """First line of the docstring."""
        return (self.function.__doc__ or "").strip().splitlines()[0]


def node(*, frames: Mode) -> Callable[[Function], Function]:
    """Declare a function as a node type and return it unchanged; BadInput where its signature is no declaration.

    `once` gives a value for the shot, `each` one per frame, `scan` one per frame from `previous`.
    """

    def declare(function: Function) -> Function:
        function.__node__ = read_signature(function, frames)  # type: ignore[attr-defined]
        return function

    return declare


def read_signature(function: Callable[..., Any], mode: Mode) -> NodeType:
    """Read a node type off a function's signature; BadInput says what is no declaration."""
    refuse = Refusal(function)
    if mode not in get_args(Mode):
        refuse(f"frames={mode!r}", "once, each or scan")
    if not (function.__doc__ or "").strip():
        refuse("no docstring", "its first line is the help of the node type")
    hints = get_type_hints(function, include_extras=True)
    parameters = inspect.signature(function).parameters.values()
    for parameter in parameters:
        if parameter.name not in hints or parameter.kind in (parameter.VAR_POSITIONAL, parameter.VAR_KEYWORD):
            refuse(f"parameter '{parameter.name}'", "every parameter is named and annotated")
    inputs = [p for p in parameters if p.kind is not p.KEYWORD_ONLY]
    special = {p.name for p in inputs if hints[p.name] in (Time, Workspace) or p.name == "previous"}
    outputs = read_outputs(hints.get("return"), refuse)
    return NodeType(
        name=function.__name__,
        mode=mode,
        function=function,
        sockets={p.name: read_socket(p, hints[p.name], mode, refuse) for p in inputs if p.name not in special},
        settings=read_settings(parameters, hints, refuse),
        outputs=outputs,
        returns=hints["return"],
        state=read_state(mode, hints if "previous" in special else {}, outputs, refuse),
        asks_time=tuple(name for name in special if hints[name] is Time),
        asks_workspace=tuple(name for name in special if hints[name] is Workspace),
    )


class Refusal:
    """Raises BadInput at the place of a function."""

    def __init__(self, function: Callable[..., Any]) -> None:
        code = function.__code__
        self.where = f"{code.co_filename}:{code.co_firstlineno}: @node {function.__name__}"

    def __call__(self, what: str, right: str) -> NoReturn:
        """Say what is wrong with the declaration and what would be right."""
        raise BadInput(what, where=self.where, right=right)


def without_none(annotation: Any) -> tuple[Any, bool]:
    """Split `T | None` into T and whether None was allowed."""
    if get_origin(annotation) in (Union, types.UnionType):
        rest = [a for a in get_args(annotation) if a is not type(None)]
        if len(rest) == 1:
            return rest[0], True
    return annotation, False


def read_socket(parameter: inspect.Parameter, annotation: Any, mode: Mode, refuse: Refusal) -> Socket:
    """Read `T`, `Pair[T]`, `Frames[T]` or `Reached[T]`, or a tuple of any number of those, each possibly `| None`."""
    name = parameter.name
    inner, optional = without_none(annotation)
    many = get_origin(inner) is tuple and get_args(inner)[1:] == (Ellipsis,)
    inner = get_args(inner)[0] if many else inner
    view: View = {Pair: "pair", Frames: "frames", Reached: "reached"}.get(get_origin(inner), "now")  # type: ignore[assignment]
    (value_type,) = get_args(inner) if view != "now" else (inner,)
    if not isinstance(value_type, type) or value_type in (Pair, Frames, Reached, Time, Workspace):
        refuse(f"socket '{name}': {annotation}", "T, Pair[T], Frames[T] or a tuple[..., ...] of one, possibly | None")
    if view == "pair" and mode == "once":
        refuse(f"socket '{name}': a `once` node has no previous frame", "T or Frames[T]")
    if parameter.default not in (parameter.empty, None) or (parameter.default is None and not optional):
        refuse(f"socket '{name}' has a default", "a socket is connected, or `T | None = None`; settings follow after *")
    return Socket(name, value_type, view, optional, many)


def read_settings(
    parameters: Iterable[inspect.Parameter], hints: dict[str, Any], refuse: Refusal
) -> dict[str, SettingField]:
    """Collect the keyword-only parameters."""
    settings = {p.name: SettingField(p.name, hints[p.name], p.default) for p in parameters if p.kind is p.KEYWORD_ONLY}
    for name in RESERVED & settings.keys():
        refuse(f"setting '{name}'", f"a graph file reserves {', '.join(sorted(RESERVED))}")
    return settings


def read_outputs(annotation: Any, refuse: Refusal) -> dict[str, type]:
    """Read the output type: a class, or a NamedTuple of classes for several outputs."""
    if not isinstance(annotation, type):
        refuse(f"returns {annotation}", "a class, or a NamedTuple for several outputs")
    if not (issubclass(annotation, tuple) and hasattr(annotation, "_fields")):
        return {SINGLE: annotation}
    outputs = get_type_hints(annotation)
    for name, kind in outputs.items():
        if not isinstance(kind, type) or not re.fullmatch("[a-z][a-z0-9_]*", name):
            refuse(f"output '{name}': {kind}", "a lower-case name and a class")
    return outputs


def read_state(mode: Mode, hints: dict[str, Any], outputs: dict[str, type], refuse: Refusal) -> str | None:
    """Find the output that comes back as `previous`: the only one of its type."""
    if mode != "scan":
        if hints:
            refuse("asks for `previous`", 'only a node declared frames="scan" has one')
        return None
    if not hints:
        refuse("does not ask for `previous`", 'frames="scan" takes a parameter `previous: T | None`')
    kind, optional = without_none(hints["previous"])
    found = [name for name, output in outputs.items() if output is kind]
    if not optional or len(found) != 1:
        refuse(f"previous: {hints['previous']}", "T | None, where exactly one output is of type T")
    return found[0]
