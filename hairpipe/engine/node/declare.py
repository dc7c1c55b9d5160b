"""`@node`: declares a typed pure function as a node type by its signature, and what a signature may name: views of
frames, time, cuts, files, a workspace, and settings that several node types share as one group.
"""

import dataclasses
import inspect
import re
import types
from collections.abc import Callable, Iterable, Iterator, Mapping
from dataclasses import dataclass, is_dataclass, replace
from functools import wraps
from pathlib import Path
from types import SimpleNamespace
from typing import (
    Annotated,
    Any,
    Generic,
    Literal,
    NamedTuple,
    NewType,
    NoReturn,
    TypeVar,
    Union,
    get_args,
    get_origin,
    get_type_hints,
)

from hairpipe.errors import BadInput
from hairpipe.units import Suffixes

T = TypeVar("T")


class Pair(NamedTuple, Generic[T]):
    """A value at the previous and at the current frame; at the first frame of the range both are the current value."""

    previous: T
    current: T


@dataclass(frozen=True)
class Time:
    """Time of an evaluation; only nodes with this parameter depend on it.

    frame  number of the frame; in a `once` node the first frame of the run
    fps    frames per second [1/s]
    """

    frame: int
    fps: float

    @property
    def dt(self) -> float:
        """Length of a frame [s]."""
        return 1.0 / self.fps


Cuts = NewType("Cuts", tuple[int, ...])
"""Frames at which the shot is cut, ascending: positions there are discontinuous with those of the previous frame.

A `once` node receives the cuts within the run, an `each` node all cuts, a scan its own frame if it is a cut.
"""


First = NewType("First", int)
"""First frame of the shot, without preroll: a longer range at its end does not change it."""


@dataclass(frozen=True)
class Origin:
    """The part of a graph that a result is computed from; only nodes with this parameter depend on it.

    Equal graphs have equal origins on all machines: without paths, times, versions, and labels of variants.

    node   name of the node in the graph file; empty outside of a graph
    key    digest of the types, settings and files of all these nodes, whatever their names are
    shot   fps, first frame, preroll and cuts of the graph
    nodes  this node and those before it, by name: `type`, `in` (sources by socket) and `settings`, plain values, with
           the digest of a file in its place
    """

    node: str = ""
    key: str = ""
    shot: Mapping[str, Any] = dataclasses.field(default_factory=dict)
    nodes: Mapping[str, Mapping[str, Any]] = dataclasses.field(default_factory=dict)


class Frames(Mapping[int, T]):
    """A value at every frame of the run, by frame number; loaded on access and not cached.

    numbers  of the frames, ascending
    load     returns the value at a frame, as in `Frames((1, 2), {1: a, 2: b}.__getitem__)`
    """

    def __init__(self, numbers: tuple[int, ...], load: Callable[[int], T]) -> None:
        self.numbers = numbers
        self._load = load
        self._known = frozenset(numbers)

    def __getitem__(self, frame: int) -> T:
        """Read the value at a frame; KeyError for a frame outside of the run."""
        if frame not in self._known:
            raise KeyError(frame)
        return self._load(frame)

    def __contains__(self, frame: object) -> bool:
        return frame in self._known

    def __iter__(self) -> Iterator[int]:
        return iter(self.numbers)

    def __len__(self) -> int:
        return len(self.numbers)


class Reached(Frames[T]):
    """A value at every frame of the run before the frame at which a scan diverged."""


@dataclass(frozen=True)
class Spent:
    """Computation time of one result, from its record; `Frames[Spent]` accepts any node.

    It is part of a key by the key of the result, not by its value: equal results of two simulations have their own
    times. The first recorded time is valid as long as code, settings and inputs of the node are unchanged.

    seconds    wall-clock time [s]
    processor  processor time of all threads and child processes [s]
    """

    seconds: float
    processor: float


Workspace = NewType("Workspace", Path)
"""A new empty folder for one evaluation of a node, which is removed afterwards."""


DATA_SUFFIXES = (
    *(".abc", ".bvh", ".csv", ".exr", ".gif", ".h5", ".jpeg", ".jpg", ".mp4", ".npy", ".npz", ".obj", ".pdf", ".png"),
    *(".tif", ".tiff", ".usd", ".usda", ".usdc", ".vdb", ".webp"),
)
"""Formats of pictures and data, which no program executes."""


@dataclass(frozen=True)
class File:
    """A file in the workspace of a node; its bytes are stored and published.

    A node declares its formats as `-> Annotated[File, Suffixes((".png",))]`, and is published with such a suffix only;
    without a declaration, with those of `DATA_SUFFIXES`.

    path        of the file
    companions  files that must be next to it, by the relative path in the file
    """

    path: Path
    companions: Mapping[str, Path] = dataclasses.field(default_factory=dict)


Mode = Literal["once", "each", "scan"]
View = Literal["now", "pair", "frames", "reached"]
Function = TypeVar("Function", bound=Callable[..., Any])

RESERVED = frozenset({"type", "in", "publish", "checkpoint", "like", "without", "mute"})
SINGLE = ""
"""Name of a single output."""
VALUES = "a frozen dataclass of arrays, such as a Table, or a File"
"""Types of values on edges."""
SPECIAL = (Time, Cuts, First, Origin, Workspace)
"""Types of parameters that take what the engine knows of an evaluation."""
PREPARED = "prepared"
"""Parameter of a node for the result of its `prepare` function."""


@dataclass(frozen=True)
class Socket:
    """An input of a node: its type, its view of frames, and whether it may stay unconnected.

    many  whether it takes a list of edges, which are named `tables.0`, `tables.1`
    """

    name: str
    type: type
    view: View
    optional: bool
    many: bool

    def plugs(self, connected: Iterable[str]) -> tuple[str, ...]:
        """List the names of its edges in order."""
        return tuple(plug for plug in connected if plug.partition(".")[0] == self.name) if self.many else (self.name,)


@dataclass(frozen=True)
class Preparation:
    """A function that is called once for many frames; its result is an argument of the node."""

    function: Callable[..., Any]
    sockets: tuple[str, ...]  # that are its arguments, with the same value at all frames
    settings: tuple[str, ...]  # that are its arguments


@dataclass(frozen=True, eq=False, repr=False)
class NodeType:
    """The declaration of a node type.

    returns         declared type, a NamedTuple of several outputs
    writes          suffixes under which its File may be published, in lower case
    state           output that a scan receives back as `previous`
    special         its parameters that take Time, Cuts, First, an Origin or a Workspace, with this type
    prepare         computes the value of the parameter `prepared`; None if absent
    tuning          module that lists simplifications, see `hairpipe/values/simplification.py`; None: none
    unvaried        sockets that all variants of a wedge connect to results of the graph file
    """

    name: str
    mode: Mode
    function: Callable[..., Any]
    sockets: dict[str, Socket]
    settings: dict[str, inspect.Parameter]
    outputs: dict[str, type]
    returns: type
    writes: tuple[str, ...]
    state: str | None
    special: dict[str, Any]
    prepare: Preparation | None
    tuning: str | None = None
    unvaried: tuple[str, ...] = ()

    def __repr__(self) -> str:
        inputs = ", ".join(f"{socket.name}: {socket.type.__name__}" for socket in self.sockets.values())
        outputs = ", ".join(f"{name}: {kind.__name__}".removeprefix(": ") for name, kind in self.outputs.items())
        return f"<NodeType {self.name}({inputs}) -> {outputs}>"

    def socket(self, plug: str) -> Socket:
        return self.sockets[plug.partition(".")[0]]

    def asks(self, kind: Any) -> bool:
        return kind in self.special.values()

    def by_output(self, result: Any) -> dict[str, Any]:
        """Return the outputs of a call by name; TypeError if they are not of the declared type."""
        if not isinstance(result, self.returns):
            raise TypeError(f"returned a {type(result).__name__}, declared {self.returns.__name__}")
        return {SINGLE: result} if SINGLE in self.outputs else result._asdict()

    @property
    def module(self) -> str:
        return self.function.__module__

    @property
    def summary(self) -> str:
        return (self.function.__doc__ or "").strip().splitlines()[0]


def node(
    *,
    frames: Mode,
    prepare: Callable[..., Any] | None = None,
    tuning: str | None = None,
    unvaried: tuple[str, ...] = (),
) -> Callable[[Function], Function]:
    """Declare a function as a node type and return it unchanged; BadInput for an invalid signature.

    frames   `once` returns a value for the shot, `each` one per frame, `scan` one per frame from `previous`
    prepare  function of settings and of inputs that are constant over the shot, with the names of the node. Its result
             is the parameter `prepared`, which the node must not change. A worker calls the function once for equal
             inputs and settings; the result is neither stored nor part of a key
    tuning   module that lists simplifications, see `hairpipe/values/simplification.py`; not part of a key
    unvaried  sockets that all variants of a wedge connect to results of the graph file, without the varied settings
    """

    def declare(function: Function) -> Function:
        found = replace(read_signature(function, frames, prepare), tuning=tuning, unvaried=unvaried)
        function.__node__ = found  # type: ignore[attr-defined]
        return function

    return declare


def read_signature(function: Callable[..., Any], mode: Mode, prepare: Callable[..., Any] | None = None) -> NodeType:
    refuse = Refusal(function)
    if mode not in get_args(Mode):
        refuse(f"frames={mode!r}", "once, each or scan")
    if not (function.__doc__ or "").strip():
        refuse("no docstring", "its first line is the help of the node type")
    try:
        hints = hints_of(function, PREPARED)
    except NameError as error:
        refuse(f"an annotation names '{error.name}', which this module does not have", "an import of it")
    parameters = inspect.signature(function).parameters.values()
    plain = [p for p in parameters if p.name != PREPARED]
    for parameter in plain:
        named = parameter.kind not in (parameter.VAR_POSITIONAL, parameter.VAR_KEYWORD)
        if parameter.annotation is parameter.empty or not named:
            refuse(f"parameter '{parameter.name}' without a type", "every parameter is named and annotated")
    inputs = [p for p in plain if p.kind is not p.KEYWORD_ONLY]
    special = {p.name for p in inputs if hints[p.name] in SPECIAL or p.name == "previous"}
    outputs, writes = read_outputs(hints.get("return"), refuse)
    declared = NodeType(
        name=function.__name__,
        mode=mode,
        function=function,
        sockets={p.name: read_socket(p, hints[p.name], mode, refuse) for p in inputs if p.name not in special},
        settings=read_settings(plain, hints, refuse),
        outputs=outputs,
        returns=bare(hints["return"]),
        writes=writes,
        state=read_state(mode, hints if "previous" in special else {}, outputs, refuse),
        special={p.name: hints[p.name] for p in inputs if hints[p.name] in SPECIAL},
        prepare=None,
    )
    return replace(declared, prepare=read_preparation(declared, prepare, refuse))


class Refusal:
    """Raises BadInput with the place of a function."""

    def __init__(self, function: Callable[..., Any]) -> None:
        code = inspect.unwrap(function).__code__
        self.where = f"{code.co_filename}:{code.co_firstlineno}: @node {function.__name__}"

    def __call__(self, what: str, right: str) -> NoReturn:
        raise BadInput(what, where=self.where, right=right)


def without_none(annotation: Any) -> tuple[Any, bool]:
    """Split `T | None` into T and whether None is permitted."""
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
        right = "T, Pair[T], Frames[T] or a tuple[..., ...] of one, possibly | None"
        refuse(f"socket '{name}': {text_of(annotation)}", right)
    if value_type is Spent and (view not in ("frames", "reached") or mode != "once"):
        refuse(f"socket '{name}': {text_of(annotation)}", 'Frames[Spent] or Reached[Spent], of a node frames="once"')
    if not is_dataclass(value_type):
        refuse(f"socket '{name}': {text_of(value_type)}", f"{VALUES}; a setting follows after *")
    if view == "pair" and mode == "once":
        refuse(f"socket '{name}': a `once` node has no previous frame", "T or Frames[T]")
    if parameter.default not in (parameter.empty, None) or (parameter.default is None and not optional):
        refuse(f"socket '{name}' has a default", "a socket is connected, or `T | None = None`; settings follow after *")
    return Socket(name, value_type, view, optional, many)


def read_settings(
    parameters: Iterable[inspect.Parameter], hints: dict[str, Any], refuse: Refusal
) -> dict[str, inspect.Parameter]:
    """Collect the keyword-only parameters, with evaluated annotations."""
    settings = {p.name: p.replace(annotation=hints[p.name]) for p in parameters if p.kind is p.KEYWORD_ONLY}
    for name, field in settings.items():
        if field.default is None and not without_none(field.annotation)[1]:
            right = f"{name}: {text_of(bare(field.annotation))} | None = None"
            refuse(f"setting '{name}' has the default None, which its type is not", right)
    for name in RESERVED & settings.keys():
        refuse(f"setting '{name}'", f"a graph file reserves {', '.join(sorted(RESERVED))}")
    return settings


def read_outputs(annotation: Any, refuse: Refusal) -> tuple[dict[str, type], tuple[str, ...]]:
    """Read the output type: a class, or a NamedTuple of classes for several outputs; and the suffixes of its File."""
    if annotation is None:
        refuse("no type of what it returns", f"-> {VALUES}, or a NamedTuple for several outputs")
    returned = bare(annotation)
    several = isinstance(returned, type) and issubclass(returned, tuple) and hasattr(returned, "_fields")
    if not several and not is_dataclass(returned):
        refuse(f"returns {text_of(annotation)}", f"{VALUES}, or a NamedTuple for several outputs")
    declared = get_type_hints(returned, include_extras=True) if several else {SINGLE: annotation}
    outputs = {name: bare(kind) for name, kind in declared.items()}
    for name, kind in outputs.items() if several else ():
        if not is_dataclass(kind) or not re.fullmatch("[a-z][a-z0-9_]*", name):
            refuse(f"output '{name}': {text_of(kind)}", f"a lower-case name and {VALUES}")
    named = [suffixes_of(declared[name], refuse) for name, kind in outputs.items() if kind is File]
    return outputs, next(filter(None, named), DATA_SUFFIXES)


def suffixes_of(annotation: Any, refuse: Refusal) -> tuple[str, ...]:
    given = next((item.names for item in get_args(annotation)[1:] if isinstance(item, Suffixes)), ())
    if not isinstance(given, tuple) or not all(re.fullmatch(r"\.[a-z0-9]+", str(name)) for name in given):
        refuse(f"writes {given!r}", 'Suffixes((".png",)): a tuple of suffixes in lower case')
    return given


def read_state(mode: Mode, hints: dict[str, Any], outputs: dict[str, type], refuse: Refusal) -> str | None:
    """Find the output that is passed as `previous` to the next frame: the only one of its type."""
    if mode != "scan":
        if hints:
            refuse("asks for `previous`", 'only a node declared frames="scan" has one')
        return None
    if not hints:
        refuse("does not ask for `previous`", 'frames="scan" takes a parameter `previous: T | None`')
    kind, optional = without_none(hints["previous"])
    found = [name for name, output in outputs.items() if output is kind]
    if not optional or len(found) != 1:
        refuse(f"previous: {text_of(hints['previous'])}", "T | None, where exactly one output is of type T")
    return found[0]


def read_preparation(node_type: NodeType, function: Callable[..., Any] | None, refuse: Refusal) -> Preparation | None:
    """Check the signature of a `prepare` function against that of its node."""
    taken = inspect.signature(node_type.function).parameters.get(PREPARED)
    if function is None:
        if taken is not None:
            refuse(f"asks for `{PREPARED}`", "@node(..., prepare=FUNCTION)")
        return None
    if not inspect.isfunction(function):
        refuse(f"prepare={function!r}", "a plain function of this module, or an imported one")
    if node_type.mode == "once":
        refuse(f"prepare={function.__name__}", 'frames="scan" or "each": a `once` node is called once anyway')
    if taken is None or taken.kind is taken.KEYWORD_ONLY:
        refuse(f"prepare={function.__name__}", f"a parameter `{PREPARED}` before the settings takes the result")
    if "return" not in function.__annotations__:
        refuse(f"prepare={function.__name__} without the type that it returns", f"def {function.__name__}(...) -> T")
    asked = text_of(taken.annotation)
    returned = text_of(function.__annotations__["return"])
    if taken.annotation is taken.empty:
        refuse(f"parameter '{PREPARED}' without a type", f"{PREPARED}: {returned}, as {function.__name__} returns it")
    if asked != returned:
        refuse(f"{PREPARED}: {asked}", f"what {function.__name__} returns: {returned}")
    names = inspect.signature(function).parameters
    sockets = tuple(s.name for s in node_type.sockets.values() if s.name in names and s.view == "now")
    settings = tuple(name for name in node_type.settings if name in names)
    own = hints_of(node_type.function, PREPARED)
    given = hints_of(function, "return")
    for parameter in names.values():
        name = parameter.name
        where = f"{function.__name__}: parameter '{parameter.name}'"
        if name not in (*sockets, *settings) or parameter.kind is parameter.POSITIONAL_ONLY:
            refuse(where, "the name of an input that is one value, T, or of a setting")
        if name not in given or bare(given[name]) != bare(own[name]):
            refuse(where, f"{name}: {text_of(bare(own[name]))}, as the node takes it")
    return Preparation(function, sockets, settings)


def hints_of(function: Callable[..., Any], left_out: str) -> dict[str, Any]:
    """Evaluate the annotations of a function, except one, which may refer to names for type checkers only."""
    annotations = {name: annotation for name, annotation in function.__annotations__.items() if name != left_out}
    return get_type_hints(SimpleNamespace(__annotations__=annotations), function.__globals__, include_extras=True)


def bare(annotation: Any) -> Any:
    inner, optional = without_none(annotation)
    inner = get_args(inner)[0] if get_origin(inner) is Annotated else inner
    return inner | None if optional else inner


def text_of(annotation: Any) -> str:
    """Write an annotation, classes by their names alone."""
    bare_class = isinstance(annotation, type) and not get_args(annotation)
    return annotation.__name__ if bare_class else re.sub(r"(?:\w+\.)+(?=\w)", "", str(annotation))


def flat_group(name: str) -> Callable[[Callable[..., Any]], Callable[..., Any]]:
    """Declare the fields of a keyword-only group as settings of the node; used below `@node`.

    name  of the parameter, annotated with a frozen dataclass whose docstring, or that of its base, documents its fields

    In a graph file the fields are settings of the node. The function receives the group. A group that raises BadInput
    refuses its fields when the graph file is read.
    """

    def flatten(function: Callable[..., Any]) -> Callable[..., Any]:
        group = function.__annotations__[name]
        hints = get_type_hints(group, include_extras=True)
        fields = dataclasses.fields(group)
        names = {field.name for field in fields}

        def grouped(settings: dict[str, Any]) -> dict[str, Any]:
            own = {key: value for key, value in settings.items() if key not in names}
            return own | {name: group(**{key: value for key, value in settings.items() if key in names})}

        @wraps(function)
        def flat(*arguments: Any, **settings: Any) -> Any:
            return function(*arguments, **grouped(settings))

        signature = inspect.signature(function)
        parameters = []
        for parameter in signature.parameters.values():
            if parameter.name != name:
                parameters.append(parameter)
                continue
            for field in fields:
                default = inspect.Parameter.empty if field.default is dataclasses.MISSING else field.default
                own = parameter.replace(name=field.name, default=default, annotation=hints[field.name])
                parameters.append(own)
        flat.__signature__ = signature.replace(parameters=parameters)  # type: ignore[attr-defined]
        flat.grouped = grouped  # type: ignore[attr-defined]
        annotations = {parameter.name: parameter.annotation for parameter in parameters}
        flat.__annotations__ = {**annotations, "return": function.__annotations__["return"]}
        explained = (function, *(base for base in group.__mro__ if dataclasses.is_dataclass(base)))
        flat.__doc__ = "\n\n".join(inspect.cleandoc(item.__doc__ or "") for item in explained)
        return flat

    return flatten
