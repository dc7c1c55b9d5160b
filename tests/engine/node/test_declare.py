"""Declarations: the signature says everything, and what it cannot say is refused where it stands."""

import inspect
import re
from dataclasses import dataclass
from pathlib import Path
from typing import Annotated, NamedTuple

import pytest

from hairpipe.engine import File, Frames, Pair, Time, Workspace, flat_group, node
from hairpipe.engine.node.declare import DATA_SUFFIXES, Cuts, Preparation
from hairpipe.errors import BadInput
from hairpipe.units import Gt, Metres, Suffixes


@dataclass(frozen=True)
class Mesh:
    """A value."""


@dataclass(frozen=True)
class State:
    """Another value."""


class Both(NamedTuple):
    """Two outputs."""

    mesh: Mesh
    state: State


def test_signature_is_read_and_the_function_stays_callable():
    @node(frames="scan")
    def simulate(
        a: Mesh,
        b: Pair[Mesh] | None,
        c: Frames[File] | None,
        previous: State | None,
        when: Time,
        place: Workspace,
        d: Mesh | None = None,
        e: tuple[Pair[Mesh], ...] | None = None,
        *,
        size: float = 2.0,
        count: int,
    ) -> Both:
        """Simulate."""
        return Both(a, State())

    found = simulate.__node__
    assert {s.name: (s.type, s.view, s.optional, s.many) for s in found.sockets.values()} == {
        "a": (Mesh, "now", False, False),
        "b": (Mesh, "pair", True, False),
        "c": (File, "frames", True, False),
        "d": (Mesh, "now", True, False),
        "e": (Mesh, "pair", True, True),
    }
    assert found.outputs == {"mesh": Mesh, "state": State} and found.state == "state"
    assert found.special == {"when": Time, "place": Workspace} and found.asks(Time) and not found.asks(Cuts)
    assert [s.default for s in found.settings.values()] == [2.0, inspect.Parameter.empty]
    mesh = Mesh()
    assert simulate(mesh, None, None, None, Time(1, 24.0), Path(), count=1).mesh is mesh


class Drawn(NamedTuple):
    """A value, and a file of a declared format."""

    mesh: Mesh
    picture: Annotated[File, Suffixes((".txt",))]


@pytest.mark.parametrize(
    ("returned", "suffixes"),
    [(File, DATA_SUFFIXES), (Annotated[File, Suffixes((".svg", ".txt"))], (".svg", ".txt")), (Drawn, (".txt",))],
)
def test_suffixes_of_a_file_are_declared(returned, suffixes):
    def draw(a: Mesh):
        """Draw."""

    draw.__annotations__["return"] = returned
    found = node(frames="once")(draw).__node__
    assert found.writes == suffixes and File in found.outputs.values()


@pytest.mark.parametrize("suffixes", [".txt", ("txt",), (".TXT",), (".tar.gz",), (".",)])
def test_suffixes_that_no_name_ends_in_are_refused(suffixes):
    def draw(a: Mesh):
        """Draw."""

    draw.__annotations__["return"] = Annotated[File, Suffixes(suffixes)]
    with pytest.raises(BadInput, match="writes "):
        node(frames="once")(draw)


INVALID = [
    ("each", "no_return(a: Mesh)"),
    ("each", "no_annotation(a) -> Mesh"),
    ("each", "stars(*a: Mesh) -> Mesh"),
    ("each", "default(a: Mesh = Mesh()) -> Mesh"),
    ("each", "optional_default(a: Mesh = None) -> Mesh"),
    ("each", "union(a: Mesh | State) -> Mesh"),
    ("each", "two(a: tuple[Mesh, State]) -> Mesh"),
    ("each", "pair_of_none(a: Pair[Mesh | None]) -> Mesh"),
    ("each", "reserved(*, publish: int = 1) -> Mesh"),
    ("each", "previous(previous: Mesh | None) -> Mesh"),
    ("each", "union_out() -> Mesh | None"),
    ("once", "pair(a: Pair[Mesh]) -> Mesh"),
    ("once", "pairs(a: tuple[Pair[Mesh], ...]) -> Mesh"),
    ("scan", "scan() -> Mesh"),
    ("scan", "scan_required(previous: Mesh) -> Mesh"),
    ("scan", "scan_other(previous: State | None) -> Mesh"),
    ("sometimes", "scan() -> Mesh"),
]


def declared(signature, document='"""D."""'):
    """A function of this signature, as if it stood in this file."""
    made = {}
    exec(compile(f"def {signature}:\n    {document}", __file__, "exec"), globals(), made)
    return made.popitem()[1]


@pytest.mark.parametrize(("frames", "signature"), INVALID)
def test_invalid_declarations_are_refused_with_their_line(frames, signature):
    function = declared(signature)
    with pytest.raises(BadInput, match=rf"test_declare\.py:\d+: @node {function.__name__}"):
        node(frames=frames)(function)


def test_a_declaration_without_a_docstring_is_refused():
    with pytest.raises(BadInput, match=r"@node bare.*docstring"):
        node(frames="each")(declared("bare() -> Mesh", "pass"))


@pytest.mark.parametrize(
    ("signature", "reported"),
    [
        ("f(a: Mesh)", r"no type of what it returns \(-> a frozen dataclass"),
        ("f(a) -> Mesh", "parameter 'a' without a type"),
        ("f(a: Mesh | State) -> Mesh", "socket 'a': Mesh | State "),
        ("f(a: Mesh) -> float", "returns float .a frozen dataclass of arrays, such as a Table"),
        ("f(a: float) -> Mesh", "socket 'a': float .*a setting follows after"),
        ("f(*, size: float = None) -> Mesh", r"setting 'size' has the default None.* \(size: float | None = None\)"),
        ("f(a: 'Missing') -> Mesh", "names 'Missing', which this module does not have"),
    ],
)
def test_invalid_declarations_are_quoted(signature, reported):
    with pytest.raises(BadInput, match=reported) as caught:
        node(frames="each")(declared(signature))
    assert not re.search(r"_empty|<class|NoneType|typing\.", str(caught.value))


def made(a: Mesh, size: float) -> State:
    """Make a state."""


def no_input(c: Mesh) -> State: ...
def a_pair(b: Pair[Mesh]) -> State: ...
def another_type(a: State) -> State: ...
def another_result(a: Mesh) -> Mesh: ...
def result_unknown(a: Mesh): ...


@pytest.mark.parametrize(
    ("prepare", "reported"),
    [
        (no_input, "no_input: parameter 'c'"),
        (a_pair, "a_pair: parameter 'b'"),
        (another_type, "another_type: parameter 'a' .a: Mesh"),
        (another_result, "prepared: State .what another_result returns: Mesh"),
        (result_unknown, "prepare=result_unknown without the type that it returns"),
        (len, "prepare=<built-in"),
        (None, "asks for `prepared`"),
    ],
)
def test_a_prepare_function_takes_inputs_and_settings_and_returns_prepared(prepare, reported):
    def simulate(a: Mesh, b: Pair[Mesh], prepared: "State", *, size: Annotated[float, Metres, Gt(0)] = 2.0) -> Mesh:
        """Simulate."""

    assert node(frames="each", prepare=made)(simulate).__node__.prepare == Preparation(made, ("a",), ("size",))
    with pytest.raises(BadInput, match=reported):
        node(frames="each", prepare=prepare)(simulate)


def test_a_prepared_value_is_taken_before_the_settings_at_each_frame():
    without = declared("without(a: Mesh) -> Mesh")
    for function in (declared("as_a_setting(a: Mesh, *, prepared: State) -> Mesh"), without):
        with pytest.raises(BadInput, match=r"prepare=made .a parameter `prepared`"):
            node(frames="each", prepare=made)(function)
    with pytest.raises(BadInput, match="a `once` node is called once anyway"):
        node(frames="once", prepare=made)(without)


@dataclass(frozen=True)
class Shared:
    """Settings that several nodes share.

    size  of all
    """

    size: float = 2.0


def test_parameter_without_a_type_is_named():
    simulate, bare = (declared(f"f({given}, *, settings: Shared) -> Mesh") for given in ("a: Mesh, prepared", "a"))
    with pytest.raises(BadInput, match=r"'prepared' without a type \(prepared: State, as made returns it\)"):
        node(frames="each", prepare=made)(flat_group("settings")(simulate))
    with pytest.raises(BadInput, match=r"parameter 'a' without a type"):
        node(frames="each")(flat_group("settings")(bare))


def test_frames_read_when_asked_and_not_before():
    read = []
    frames = Frames((3, 5), lambda frame: read.append(frame) or frame * 10)
    assert list(frames) == [3, 5] == list(frames.numbers) and len(frames) == 2 and 5 in frames and read == []
    assert dict(frames.items()) == {3: 30, 5: 50} and frames[3] == 30
    assert read == [3, 5, 3]
    with pytest.raises(KeyError):
        frames[4]


def test_time_has_the_duration_of_a_frame():
    assert Time(7, 25.0).dt == 0.04
