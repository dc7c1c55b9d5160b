"""The laws of the house: who imports whom, what lies where, and that it is documented and typed."""

import ast
import re
import subprocess
import sys
import tomllib
from collections import Counter
from collections.abc import Iterator
from graphlib import TopologicalSorter
from pathlib import Path

import pytest

from .rooms import (
    BUDGETS,
    MOST_CLOSURE,
    MOST_FILES,
    MOST_LINES,
    MOST_SINGLE,
    PATHS,
    closure_of,
    lines_of_rooms,
    single_importers,
)
from .sources import HOME, PACKAGES, SOURCES, imports_of, module_of, name_of, tree_of

ORDER = (
    *("errors", "units"),  # what everything may need
    *("plain_file", "child", "apart", "processor", "openvdb_library"),
    *("values", "geometry", "body", "levelset", "groom"),
    *("laws", "strands", "solve", "volume", "contact", "shot", "particles", "measure"),
)
"""Rooms from the bottom up: the files of one import from it and from those before it."""
WITHIN = {
    "experiments.studies": "theory accuracy integrators interpolation contact knots",
    "engine": "node store file edit code plan worker hosts run",
}
"""The same within a room, for its folders and files: one imports from itself and from those before it."""
BASE = {"errors", "units", "plain_file", "child", "apart", "processor", "openvdb_library", "values"}
PURE = {
    "engine.node.messages",  # names what is wrong, on one line
    "engine.file.overrides",  # edits tables of a graph file
    "engine.edit",  # edits its text
    "engine.store.digest",  # digests plain values
    "engine.store.atomic",  # writes files whole or not at all
    "engine.worker.threading_layer",  # chooses a setting of numba
    "engine.store.ownership",  # names the folders of a user
}
"""What tools may use of the engine besides `hairpipe.app.api`: it neither loads, plans nor runs anything."""
ASKED = {"engine.file.trust"}  # before anything is loaded, a person is asked whether code is trusted
CHECKOUT = {"experiments"}
"""Experiments, which only a checkout has: commands that need them say so."""
ROOMS = {
    **{room: set(ORDER[:place]) for place, room in enumerate(ORDER)},
    "render": {*BASE, "geometry"},
    "formats": BASE,
    "blender": {*BASE, "formats"},
    "engine": {"errors", "units", "child", "plain_file", "processor"},
    "__init__": {"app.api", "errors"},
    "nodes": {*ORDER, "render", "formats", "engine"},
    "graphs": {*ORDER, "formats", "assets"},
    "app.api": {"values", "errors", "engine", "graphs", "formats", "plain_file"},
    "app.tune": {*BASE, "app.api", *PURE, "measure.ensemble", "measure.climate"},
    "app.page": {*BASE, "app.api", "app.wedge", "formats", "geometry", "engine.File", *PURE},
    "app.wedge": {*BASE, "app.api", "formats", *PURE},
    "app.farm": {"errors", "app.api"},
    "app.bridge": {*BASE, "app.api", *PURE},
    "cli": {"app.cli"},
    "app.cli": {*BASE, "cli", "app", "blender", "formats", "engine.File", *PURE, *ASKED, *CHECKOUT},
    "experiments.bench": {*ORDER, "render", "engine", "formats", "app", *CHECKOUT},
    "experiments.chart": BASE,
    "experiments.commands": {*BASE, "app", *PURE, *CHECKOUT},
    "experiments.elastic": {*ORDER},
    "experiments.figures": {*BASE, "app.api", "formats", "engine", *CHECKOUT},
    "experiments.measure": {*ORDER, "experiments.elastic"},
    "experiments.peers": {*ORDER},
    "experiments.table": {*BASE, "experiments.validation.row"},
    "experiments.scenes": {*ORDER, "engine", "app"},
    "experiments.studies": {*ORDER, "experiments.measure"},
    "experiments.nodes": {*ORDER, "render", "formats", "engine", "experiments"},
    "experiments.validation": {*BASE, "app.api", *CHECKOUT},
    "docs": {*BASE, "app", "blender", "formats", "__init__", *CHECKOUT},
}
"""Which other rooms the files of a room may import."""
OPENVDB = ("hairpipe/openvdb_library.py", "hairpipe/levelset/bake.py")
PLACES = {
    "pxr": ("hairpipe/formats/usd/", "docs/howto/deform_guides.py"),
    "alembic3d": "hairpipe/formats/alembic.py",
    "bpy": ("hairpipe/render/cycles", "hairpipe/blender/", "docs/blender_pictures.py", *OPENVDB),
    **dict.fromkeys(("openvdb", "pyopenvdb"), OPENVDB),
    "blosc": "hairpipe/formats/vdb.py",
    "h5py": "hairpipe/formats/hdf5.py",
    "PIL": "hairpipe/formats/",
    "matplotlib": "graphs/experiments/chart/",
    "pydantic": ("hairpipe/engine/node/settings.py", "hairpipe/engine/store/store.py"),
    "click": ("hairpipe/app/cli/", "graphs/experiments/"),
    "tomlkit": ("hairpipe/engine/edit.py", "hairpipe/app/tune/report.py"),
    "rich": "hairpipe/app/cli/",
    "distributed": ("hairpipe/engine/hosts/dask_engine.py", "graphs/experiments/bench/engine/dask_cluster.py"),
    "starlette": "hairpipe/app/page/server.py",
    "uvicorn": "hairpipe/app/page/server.py",
    "sphinx": "docs/",
    "docutils": "docs/",
    "elastica": "graphs/experiments/peers/",
    "pypbd": "graphs/experiments/peers/",
    "newton": "graphs/experiments/peers/",
    "warp": "graphs/experiments/peers/",
}
"""Where alone a foreign library may be imported."""
VALUE_IMPORTS = {"numpy", "hairpipe", *sys.stdlib_module_names}
HEAVY = {"numba", "scipy", *PLACES} - {"click"}
CODE_GENERATORS = ("hairpipe/geometry/simd.py", "hairpipe/geometry/simd_vec4.py", "hairpipe/geometry/compile.py")
"""Its functions are called by numba, with types that numba chooses."""
MOST_NODE_LINES = 60
MOST_PARAMETERS, MOST_LONG_SIGNATURES = 8, 5
LONG_SIGNATURES = {
    "hairpipe/app/api/graph_shot.py run": "its parameters are the options of a run",
    "hairpipe/app/cli/commands/run.py run": "its parameters are the options of a command",
    "hairpipe/app/cli/commands/tune.py tune": "its parameters are the options of a command",
    "graphs/experiments/commands/validate.py validate": "its parameters are the options of a command",
}
"""The functions with more parameters, and why; those of nodes are settings, which a graph names."""


def room_of(path: Path) -> str:
    first, *inner = path.relative_to(HOME).with_suffix("").parts
    if first == "graphs" and inner[0] == "experiments":
        return ".".join(inner[:2])
    if first == "hairpipe" and inner[0] == "app":
        return ".".join(inner[:2])
    return inner[0] if first == "hairpipe" else first


def is_node(path: Path) -> bool:
    """Whether a file declares a node: of every graph, or of the experiments."""
    return path.parent.name == "nodes" and path.stem != "__init__"


def is_allowed(room: str, target: str) -> bool:
    """Whether a room may import this module of ours."""
    allowed = {room} | ROOMS.get(room, set())
    inner = target.removeprefix("hairpipe.").removeprefix("graphs.")
    bare = target in ("hairpipe", "hairpipe.__version__")
    return bare or any(inner == name or inner.startswith(f"{name}.") for name in allowed)


def functions_of(tree: ast.AST) -> Iterator[ast.FunctionDef | ast.AsyncFunctionDef]:
    return (item for item in ast.walk(tree) if isinstance(item, ast.FunctionDef | ast.AsyncFunctionDef))


def parameters_of(function: ast.FunctionDef | ast.AsyncFunctionDef) -> list[ast.arg]:
    """List the parameters of a function, but for the object of a method."""
    given = function.args
    named = [*given.posonlyargs, *given.args, *given.kwonlyargs, given.vararg, given.kwarg]
    return [parameter for parameter in named if parameter and parameter.arg not in ("self", "cls")]


def written_in(function: ast.FunctionDef | ast.AsyncFunctionDef) -> Iterator[ast.expr]:
    for item in ast.walk(function):
        if isinstance(item, ast.Assign | ast.AugAssign | ast.AnnAssign):
            for target in item.targets if isinstance(item, ast.Assign) else [item.target]:
                yield from target.elts if isinstance(target, ast.Tuple) else [target]


def whole_of(target: ast.expr) -> ast.expr:
    """Return what an assignment changes a part of: a.b of a.b[i][0]."""
    while isinstance(target, ast.Subscript):
        target = target.value
    return target


def floor_of(module: str, order: list[str]) -> int | None:
    """Find the place in an order of the innermost unit that holds a module, or a name of one."""
    held = [unit for unit in order if f"{module}.".startswith(f"{unit}.")]
    return order.index(max(held, key=len)) if held else None


def is_compiled(function: ast.FunctionDef | ast.AsyncFunctionDef) -> bool:
    return any(
        name in ast.unparse(decorator)
        for name in ("njit", "inlined", "intrinsic")
        for decorator in function.decorator_list
    )


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


def test_rooms_keep_their_budgets():
    lines = lines_of_rooms()
    over = {room: (lines[room], most) for room, (_, most) in BUDGETS.items() if lines[room] > most}
    assert not over, f"lines and budget, see `python -m tests.rooms`: {over}"
    assert sum(lines.values()) <= MOST_LINES
    assert sum(path.is_relative_to(HOME / "hairpipe") for path in SOURCES) <= MOST_FILES


def test_few_files_serve_one_other_alone():
    assert len(single_importers()) <= MOST_SINGLE, single_importers()


def test_a_reader_of_simulate_hair_reads_few_files():
    assert len(closure_of("hairpipe.nodes.simulate_hair")) <= MOST_CLOSURE


def test_locks_are_used_through_one_module():
    wrong = [
        f"{name_of(path)} imports {target}"
        for path in SOURCES
        for target in imports_of(path)
        if "/shot/lock" not in name_of(path) and target.startswith("hairpipe.shot.lock_")
    ]
    assert not wrong, "\n".join(wrong)


def test_modules_import_each_other_in_no_circle():
    """What a file imports before it runs, directly or through others, never leads back to it."""
    first: dict[str, set[str]] = {}
    for name, path in PATHS.items():
        lines = [item for item in tree_of(path).body if isinstance(item, ast.Import | ast.ImportFrom)]
        named = [f"{getattr(line, 'module', '')}.{alias.name}".strip(".") for line in lines for alias in line.names]
        first[name] = {each if each in PATHS else each.rpartition(".")[0] for each in named} & PATHS.keys()
    TopologicalSorter(first).prepare()  # CycleError names a circle


def test_no_node_imports_a_node_and_the_engine_only_by_its_public_names():
    public = re.compile(
        r"hairpipe\.engine\.(node|flat_group|Cuts|File|First|Frames|Origin|Pair|Reached|Spent|Time|Workspace)"
    )
    wrong = [
        f"{name_of(path)} imports {target}"
        for path in SOURCES
        if is_node(path)
        for target in imports_of(path)
        if ".nodes." in target or (f"{target}.".startswith("hairpipe.engine.") and not public.fullmatch(target))
    ]
    assert not wrong, "\n".join(wrong)


def test_values_need_numpy_alone():
    wrong = [
        f"{name_of(path)} imports {target}"
        for path in SOURCES
        if room_of(path) == "values"
        for target in imports_of(path)
        if target.partition(".")[0] not in VALUE_IMPORTS
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


@pytest.mark.parametrize("path", [path for path in SOURCES if is_node(path)], ids=name_of)
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


def test_no_two_files_of_a_room_have_the_same_name():
    names = Counter((room_of(path), path.name) for path in SOURCES if path.name != "__init__.py")
    assert not [name_of(path) for path in SOURCES if names[room_of(path), path.name] > 1]


@pytest.mark.parametrize("room", WITHIN)
def test_files_of_a_room_import_only_what_is_below_them(room):
    home = "hairpipe.graphs" if room.startswith("experiments.") else "hairpipe"
    order = [f"{home}.{room}.{unit}" for unit in WITHIN[room].split()]
    own = [path for path in SOURCES if room_of(path) == room and path.name != "__init__.py"]
    unused = [unit for unit in order if not any(floor_of(module_of(path), [unit]) == 0 for path in own)]
    assert not unused, f"nothing is in {unused}"
    wrong = []
    for path in own:
        floor = floor_of(module_of(path), order)
        if floor is None:
            wrong.append(f"{name_of(path)} has no place in the order")
            continue
        above = [target for target in imports_of(path) if (floor_of(target, order) or 0) > floor]
        wrong += [f"{name_of(path)} imports {target}" for target in above]
    assert not wrong, "\n".join(wrong)


def test_few_functions_have_long_signatures():
    assert len(LONG_SIGNATURES) <= MOST_LONG_SIGNATURES
    long = {
        f"{name_of(path)} {function.name}"
        for path in SOURCES
        if path.parent.name != "nodes"
        for function in functions_of(tree_of(path))
        if len(parameters_of(function)) > MOST_PARAMETERS
    }
    assert long == set(LONG_SIGNATURES)


def test_names_that_other_files_import_are_documented():
    imported = {name for path in SOURCES for name in imports_of(path)}
    wrong = [f"{name_of(path)}: no docstring" for path in SOURCES if not ast.get_docstring(tree_of(path))]
    wrong += [
        f"{name_of(path)}:{item.lineno} {item.name}: no docstring"
        for path in SOURCES
        for item in tree_of(path).body
        if isinstance(item, ast.FunctionDef | ast.ClassDef)
        and not item.name.startswith("_")
        and f"{module_of(path)}.{item.name}" in imported
        and not is_documented(item)
    ]
    assert not wrong, "\n".join(wrong)


def test_every_function_is_annotated():
    """What numba compiles may take a lane or an array, of 32 bits or 64: only there types are left to it."""
    wrong = []
    for path in SOURCES:
        for function in functions_of(tree_of(path)):
            bare = [parameter.arg for parameter in parameters_of(function) if parameter.annotation is None]
            bare += ["return"] if function.returns is None else []
            if bare and not is_compiled(function) and name_of(path) not in CODE_GENERATORS:
                wrong.append(f"{name_of(path)}:{function.lineno} {function.name}: {', '.join(bare)}")
    assert not wrong, "\n".join(wrong)


def test_no_parallel_loop_writes_to_a_member_of_a_record_itself():
    """Numba drops such writes without a word, see `hairpipe/geometry/compile.py`."""
    wrong = [
        f"{name_of(path)}:{target.lineno} {function.name}: {ast.unparse(target)}"
        for path in SOURCES
        for function in functions_of(tree_of(path))
        if any("parallel=True" in ast.unparse(decorator) for decorator in function.decorator_list)
        for target in written_in(function)
        if isinstance(target, ast.Subscript) and isinstance(whole_of(target), ast.Attribute)
    ]
    assert not wrong, "\n".join(wrong)


def test_no_package_imports_anything_heavy():
    names = [".".join(("hairpipe", *path.parts[path.parts[0] == "hairpipe" :])) for path in PACKAGES]
    code = "import sys, importlib\nfor name in sys.argv[1:]: importlib.import_module(name)\nprint(*sys.modules)"
    loaded = subprocess.run([sys.executable, "-c", code, *names], capture_output=True, text=True, check=True)
    assert not HEAVY & set(loaded.stdout.split())


def test_a_wheel_has_every_package():
    with (HOME / "pyproject.toml").open("rb") as file:
        listed = tomllib.load(file)["tool"]["setuptools"]["packages"]
    held = [path for path in PACKAGES if "experiments" not in path.parts]
    names = {".".join(("hairpipe", *path.parts[path.parts[0] == "hairpipe" :])) for path in held}
    assert sorted(listed) == sorted(names)
