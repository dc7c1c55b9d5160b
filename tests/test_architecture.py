"""The laws of the house: who imports whom, what lies where, how long it is, and that it is documented and typed."""

import ast
import re
import subprocess
import sys
import tomllib
from collections.abc import Iterator
from pathlib import Path

import pytest

HOME = Path(__file__).resolve().parents[1]
SOURCES = sorted(path for room in ("hairpipe", "nodes", "graphs") for path in (HOME / room).rglob("*.py"))
TESTS = sorted((HOME / "tests").rglob("*.py"))
PACKAGES = sorted(path.parent.relative_to(HOME) for path in SOURCES if path.name == "__init__.py")

ORDER = (
    *("errors", "units", "plain_file", "child"),  # what everything may need
    *("kernels", "data", "spatial", "volume", "body", "levelset", "groom", "scripted_ends"),
    *("sim", "table", "measure", "studies"),
)
"""Rooms from the bottom up: the files of one import from it and from those before it."""
BASE = {"errors", "units", "plain_file", "child", "data"}
ROOMS = {
    **{room: set(ORDER[:place]) for place, room in enumerate(ORDER)},
    "render": {*BASE, "spatial", "volume", "groom"},
    "chart": BASE,
    "io": BASE,
    "graph": {"errors", "units", "child", "plain_file"},
    "bench": {*ORDER, "graph"},
    "nodes": {*ORDER, "render", "chart", "io", "graph"},
    "graphs": {*ORDER, "io"},
    "tune": {*BASE, "graph"},
    "cli": {"bench", "child", "errors", "graph", "graphs", "io", "levelset.vdb", "plain_file", "tune"},
}
"""Which other rooms the files of a room may import."""
PLACES = {
    "pxr": "hairpipe/io/usd/",
    "h5py": "hairpipe/io/hdf5.py",
    "openvdb": "hairpipe/levelset/vdb.py",
    "pyopenvdb": "hairpipe/levelset/vdb.py",
    "bpy": "hairpipe/levelset/vdb.py",
    "PIL": "hairpipe/io/",
    "matplotlib": "hairpipe/chart/",
    "pydantic": "hairpipe/graph/node/settings.py",
    "click": "hairpipe/cli/",
    "rich": "hairpipe/cli/",
}
"""Where alone a foreign library may be imported."""
DATA_IMPORTS = {"numpy", "hairpipe", *sys.stdlib_module_names}
HEAVY = {"numba", "pxr", "h5py", "scipy", "matplotlib", "PIL", "pydantic", "rich"}
CODE_GENERATORS = ("hairpipe/kernels/simd.py", "hairpipe/kernels/simd_vec4.py", "hairpipe/kernels/prefetch.py")
"""Its functions are called by numba, with types that numba chooses."""
MOST_LINES, MOST_NODE_LINES = 400, 60


def tree_of(path: Path) -> ast.Module:
    return ast.parse(path.read_text(encoding="utf-8"), str(path))


def name_of(path: Path) -> str:
    return path.relative_to(HOME).as_posix()


def imports_of(path: Path) -> Iterator[str]:
    """Name the modules that a file imports, those in functions and those by `importlib` too."""
    for item in ast.walk(tree_of(path)):
        if isinstance(item, ast.Import):
            yield from (alias.name for alias in item.names)
        elif isinstance(item, ast.ImportFrom):
            assert item.level == 0, f"{path}: relative import"
            yield from (f"{item.module}.{alias.name}" for alias in item.names)
        elif isinstance(item, ast.Call) and ast.unparse(item.func).endswith(("import_module", "find_spec")):
            yield from (value.value for value in item.args if isinstance(value, ast.Constant) and value.value)


def room_of(path: Path) -> str:
    parts = path.relative_to(HOME).with_suffix("").parts
    return parts[1] if parts[0] == "hairpipe" else parts[0]


def is_allowed(room: str, target: str) -> bool:
    """Whether a room may import this module of ours."""
    allowed = {room} | ROOMS.get(room, set())
    inner = target.removeprefix("hairpipe.")
    bare = target in ("hairpipe", "hairpipe.__version__")
    return bare or any(inner == name or inner.startswith(f"{name}.") for name in allowed)


def functions_of(tree: ast.AST) -> Iterator[ast.FunctionDef]:
    return (item for item in ast.walk(tree) if isinstance(item, ast.FunctionDef | ast.AsyncFunctionDef))


def is_compiled(function: ast.FunctionDef) -> bool:
    return any(
        name in ast.unparse(decorator)
        for name in ("njit", "inlined", "intrinsic")
        for decorator in function.decorator_list
    )


def public_of(body: list[ast.stmt], prefix: str = "") -> Iterator[tuple[str, ast.FunctionDef | ast.ClassDef]]:
    """List the public functions and classes of a module, with the public methods of those."""
    for item in body:
        if isinstance(item, ast.FunctionDef | ast.ClassDef) and not item.name.startswith("_"):
            yield prefix + item.name, item
            if isinstance(item, ast.ClassDef):
                yield from public_of(item.body, f"{prefix}{item.name}.")


def is_documented(item: ast.FunctionDef | ast.ClassDef) -> bool:
    """Whether there is a docstring, or a class takes that of another one on."""
    takes_on = any(isinstance(line, ast.Assign) and ast.unparse(line.targets[0]) == "__doc__" for line in item.body)
    return takes_on or ast.get_docstring(item) is not None


def test_rooms_import_only_what_they_may():
    wrong = [
        f"{name_of(path)} imports {target}"
        for path in SOURCES
        for target in imports_of(path)
        if target.partition(".")[0] == "hairpipe" and not is_allowed(room_of(path), target)
    ]
    assert not wrong, "\n".join(wrong)


def test_no_node_imports_a_node_and_the_engine_only_by_its_public_names():
    public = re.compile(r"hairpipe\.graph\.(node|flat_group|File|Frames|Pair|Reached|Time|Workspace)")
    wrong = [
        f"{name_of(path)} imports {target}"
        for path in SOURCES
        if room_of(path) == "nodes"
        for target in imports_of(path)
        if target.startswith("hairpipe.nodes") or (target.startswith("hairpipe.graph") and not public.fullmatch(target))
    ]
    assert not wrong, "\n".join(wrong)


def test_data_needs_numpy_alone():
    wrong = [
        f"{name_of(path)} imports {target}"
        for path in SOURCES
        if room_of(path) == "data"
        for target in imports_of(path)
        if target.partition(".")[0] not in DATA_IMPORTS
    ]
    assert not wrong, "\n".join(wrong)


def test_a_foreign_library_lives_in_one_place():
    wrong = [
        f"{name_of(path)} imports {target}"
        for path in SOURCES
        for target in imports_of(path)
        if not name_of(path).startswith(PLACES.get(target.partition(".")[0], ""))
    ]
    assert not wrong, "\n".join(wrong)


@pytest.mark.parametrize("path", [p for p in SOURCES if room_of(p) == "nodes" and p.stem != "__init__"], ids=name_of)
def test_a_node_file_declares_one_node_of_its_name(path):
    tree = tree_of(path)
    declared = [
        function.name
        for function in functions_of(tree)
        if any(ast.unparse(decorator).startswith("node(") for decorator in function.decorator_list)
    ]
    assert declared == [path.stem]
    words = sum(len((ast.get_docstring(item) or "").splitlines()) for item in [tree, *functions_of(tree)])
    assert len(path.read_text(encoding="utf-8").splitlines()) - words <= MOST_NODE_LINES


def test_files_are_short():
    lengths = {name_of(path): len(path.read_text(encoding="utf-8").splitlines()) for path in [*SOURCES, *TESTS]}
    assert not {name: length for name, length in lengths.items() if length > MOST_LINES}
    own = sorted(length for name, length in lengths.items() if not name.startswith("tests/"))
    assert own[len(own) // 2] <= 80, "the median file is too long"


def test_what_is_public_is_documented():
    wrong = [f"{name_of(path)}: no docstring" for path in SOURCES if not ast.get_docstring(tree_of(path))]
    wrong += [
        f"{name_of(path)}:{item.lineno} {name}: no docstring"
        for path in SOURCES
        for name, item in public_of(tree_of(path).body)
        if not is_documented(item)
    ]
    assert not wrong, "\n".join(wrong)


def test_every_function_is_annotated():
    """What numba compiles may take a lane or an array, of 32 bits or 64: only there types are left to it."""
    wrong = []
    for path in SOURCES:
        for function in functions_of(tree_of(path)):
            arguments = function.args
            named = [*arguments.posonlyargs, *arguments.args, *arguments.kwonlyargs, arguments.vararg, arguments.kwarg]
            bare = [a.arg for a in named if a and a.annotation is None and a.arg not in ("self", "cls")]
            bare += ["return"] if function.returns is None else []
            if bare and not is_compiled(function) and name_of(path) not in CODE_GENERATORS:
                wrong.append(f"{name_of(path)}:{function.lineno} {function.name}: {', '.join(bare)}")
    assert not wrong, "\n".join(wrong)


def test_no_package_imports_anything_heavy():
    names = [".".join(("hairpipe", *path.parts[path.parts[0] == "hairpipe" :])) for path in PACKAGES]
    code = "import sys, importlib\nfor name in sys.argv[1:]: importlib.import_module(name)\nprint(*sys.modules)"
    loaded = subprocess.run([sys.executable, "-c", code, *names], capture_output=True, text=True, check=True)
    assert not HEAVY & set(loaded.stdout.split())


def test_a_wheel_has_every_package():
    with (HOME / "pyproject.toml").open("rb") as file:
        listed = tomllib.load(file)["tool"]["setuptools"]["packages"]
    names = {".".join(("hairpipe", *path.parts[path.parts[0] == "hairpipe" :])) for path in PACKAGES}
    assert sorted(listed) == sorted(names)
