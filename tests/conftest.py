"""What tests of several rooms need: the data beside the checkout, simple meshes, a number of threads."""

import gc
import importlib.util
import os
import re
import signal
import subprocess
import sys
import tempfile
from collections.abc import Callable, Iterator
from pathlib import Path
from types import ModuleType, SimpleNamespace
from typing import Any

import numpy as np
import pytest

from hairpipe.app.api.graph_shot import GraphShot
from hairpipe.engine.file.bounds import VARIABLE, data_folder
from hairpipe.engine.hosts import host as member
from hairpipe.engine.hosts.host import Member
from hairpipe.engine.worker.machine_code import guard_kernels, share_kernels
from hairpipe.openvdb_library import find_openvdb, imported
from hairpipe.values import Mesh

from . import forked_workers as forked

# A shell that starts this in the background has it ignore Ctrl-C, and what the tests start would inherit that.
signal.signal(signal.SIGINT, signal.default_int_handler)
# Where the caller keeps results is no place for those of tests.
os.environ.pop("HAIRPIPE_CACHE", None)
# What the user has trusted and published is no business of tests, nor theirs of his.
_OWN = tempfile.TemporaryDirectory(prefix="hairpipe-own-")
os.environ["XDG_CONFIG_HOME"], os.environ["XDG_STATE_HOME"] = f"{_OWN.name}/config", f"{_OWN.name}/state"
# Third-party data is there for tests that ask for it alone: all others show that nothing else needs it. Processes of
# xdist inherit where it lies.
_ABSENT = Path(_OWN.name, "absent")
_DATA = Path(os.environ.setdefault("HAIRPIPE_DATA_OF_TESTS", str(data_folder() or _ABSENT)))
os.environ[VARIABLE] = str(_ABSENT)
# What most tests wait for is the compiler: the level below what ships takes it less time, for a little slower code.
os.environ.setdefault("NUMBA_OPT", "2")
# Tests, too, must never run old machine code of a helper that was edited; they share what runs have compiled.
# A process of xdist has inherited what the one that started it was told.
guard_kernels() if "PYTEST_XDIST_WORKER" in os.environ else share_kernels()

# What pytest and Python make of the files that they collect is kept, also where Python writes no bytecode: each process
# would make it again, for seconds. From the first test on nothing is kept: a test may edit a file twice in a second.
sys.dont_write_bytecode = False

# Compiling makes and keeps many small objects, which the collector would go through again and again.
gc.set_threshold(100_000, 20, 100)

COMPILED_FIRST = (
    *("laws", "strands", "solve", "contact", "shot", "experiments", "measure", "nodes", "app/tune"),
    *("test_graphs.py", "levelset", "geometry"),
)
"""Rooms whose tests wait for kernels, most of them for the same: one process begins with these, the other elsewhere."""


CAMPAIGNS = ("app/page", "engine", "experiments/bench")
"""Rooms whose slow tests are a campaign: of browsers, of clusters, of runs that are killed."""


@pytest.hookimpl(tryfirst=True)  # before tests are chosen by their marks
def pytest_collection_modifyitems(items: list[pytest.Item]) -> None:
    """Mark tests that wait and those of campaigns, and put those that need many kernels first.

    Of the slow tests of a campaign `make test` runs the first one of each file: begin with the widest.

    The order counts: xdist hands each process a stretch of tests that follow one another. Tests of other rooms whose
    processes compile come last: by then most of their kernels have been compiled. Nothing is imported for collection
    any more.
    """
    here = Path(__file__).parent
    begun: set[Path] = set()
    for item in items:
        if item.get_closest_marker("slow") and any(item.path.is_relative_to(here / room) for room in CAMPAIGNS):
            if item.path in begun:
                item.add_marker("campaign")
            begun.add(item.path)
        waiting = item.path.is_relative_to(here / "app" / "page") or item.path.name.startswith("test_dask")
        if waiting or re.match(r"test.*(interrupt|ctrl_c)", item.name.partition("[")[0]):
            item.add_marker("waits")

    def place_of(item: pytest.Item) -> int:
        rooms = (place for place, room in enumerate(COMPILED_FIRST) if item.path.is_relative_to(here / room))
        return next(rooms, len(COMPILED_FIRST) + bool(item.get_closest_marker("kernels")))

    items.sort(key=place_of)
    sys.dont_write_bytecode = True


@pytest.fixture(scope="session")
def shared() -> Path:
    """Give the folder of third-party data, which is not shipped; skipped where it is absent."""
    if not _DATA.is_dir():
        pytest.skip(f"third-party data absent: no {_DATA}; see `hairpipe data check`")
    return _DATA


@pytest.fixture(scope="session")
def find_data() -> Callable[[pytest.MonkeyPatch], bool]:
    """Let graphs find third-party data for as long as a patch lasts; returns whether there is any."""

    def find(patch: pytest.MonkeyPatch) -> bool:
        patch.setenv(VARIABLE, str(_DATA))
        return _DATA.is_dir()

    return find


@pytest.fixture
def third_party(shared: Path, find_data: Callable, monkeypatch: pytest.MonkeyPatch) -> None:
    """Let graphs find third-party data in one test, which is skipped where it is absent."""
    find_data(monkeypatch)


def make_sphere(radius: float = 1.0, centre=(0.0, 0.0, 0.0), level: int = 4) -> Mesh:
    """An octahedron, every triangle cut into 4^level, blown up to a sphere."""
    points = np.array([[1, 0, 0], [-1, 0, 0], [0, 1, 0], [0, -1, 0], [0, 0, 1], [0, 0, -1]], float)
    triangles = np.array([[0, 2, 4], [2, 1, 4], [1, 3, 4], [3, 0, 4], [2, 0, 5], [1, 2, 5], [3, 1, 5], [0, 3, 5]])
    for _ in range(level):
        sides = np.sort(triangles[:, [[0, 1], [1, 2], [2, 0]]].reshape(-1, 2), axis=1)
        edges, where = np.unique(sides, axis=0, return_inverse=True)
        (a, b, c), (x, y, z) = triangles.T, len(points) + where.reshape(-1, 3).T
        middles = points[edges].sum(axis=1)
        points = np.concatenate([points, middles / np.linalg.norm(middles, axis=1, keepdims=True)])
        triangles = np.concatenate([np.stack(t, axis=1) for t in ((a, x, z), (x, b, y), (z, y, c), (x, y, z))])
    return Mesh(points * radius + np.array(centre), triangles.astype(np.int32))


def make_box(low=(-0.5, -0.5, -0.5), high=(0.5, 0.5, 0.5)) -> Mesh:
    points = np.array([[x, y, z] for x in (0, 1) for y in (0, 1) for z in (0, 1)], float)
    quads = [(0, 1, 3, 2), (4, 6, 7, 5), (0, 4, 5, 1), (2, 3, 7, 6), (0, 2, 6, 4), (1, 5, 7, 3)]
    triangles = [t for a, b, c, d in quads for t in ((a, b, c), (a, c, d))]
    return Mesh(np.array(low) + points * (np.array(high) - np.array(low)), np.array(triangles, np.int32))


def make_sheet(columns: int, rows: int) -> Mesh:
    """The unit square of the plane z = 0, facing +Z, with texture coordinates (x, y); its triangles face all ways."""
    x, y = np.meshgrid(np.linspace(0, 1, columns + 1), np.linspace(0, 1, rows + 1))
    points = np.stack([x.ravel(), y.ravel(), np.zeros(x.size)], axis=1)
    i, j = np.meshgrid(np.arange(columns), np.arange(rows))
    a = (j * (columns + 1) + i).ravel()
    b, c, d = a + 1, a + columns + 2, a + columns + 1
    even = ((i + j) % 2 == 0).ravel()[:, None]
    first = np.where(even, np.stack([a, b, c], 1), np.stack([b, d, a], 1))
    second = np.where(even, np.stack([c, d, a], 1), np.stack([d, b, c], 1))
    triangles = np.concatenate([first, second]).astype(np.int32)
    return Mesh(points, triangles, uv=points[triangles][:, :, :2].astype(np.float32))


def mesh_facts(points: np.ndarray, triangles: np.ndarray) -> dict:
    """Euler number, whether closed and consistently turned, volume, smallest area and shape of the triangles."""
    directed = np.concatenate([triangles[:, (0, 1)], triangles[:, (1, 2)], triangles[:, (2, 0)]])
    codes = np.sort(directed.astype(np.int64) @ [len(points), 1])
    reverse = np.sort(directed[:, ::-1].astype(np.int64) @ [len(points), 1])
    a, b, c = (points[triangles[:, i]] for i in range(3))
    areas = 0.5 * np.linalg.norm(np.cross(b - a, c - a), axis=1)
    squares = sum((edge**2).sum(axis=1) for edge in (b - a, c - b, a - c))
    return {
        "euler": len(points) - len(directed) // 2 + len(triangles),
        "closed": len(np.unique(codes)) == len(codes) and np.array_equal(codes, reverse),
        "volume": np.einsum("ij,ij->", a, np.cross(b, c)) / 6.0,
        "areas": areas,
        "shape": 4.0 * np.sqrt(3.0) * areas / squares,  # 1 for an equilateral triangle, 0 for a degenerate one
    }


@pytest.fixture(scope="session")
def sphere() -> Callable[..., Mesh]:
    return make_sphere


@pytest.fixture(scope="session")
def box() -> Callable[..., Mesh]:
    return make_box


@pytest.fixture(scope="session")
def sheet() -> Callable[..., Mesh]:
    return make_sheet


@pytest.fixture(scope="session")
def measure_mesh() -> Callable[..., dict]:
    return mesh_facts


@pytest.fixture(scope="session")
def blender() -> None:
    """Skip where there is no Blender as a module. It is not imported: it changes the module path of its process."""
    if importlib.util.find_spec("bpy") is None:
        pytest.skip("no bpy in this environment")


@pytest.fixture(scope="session")
def openvdb() -> ModuleType:
    """Give OpenVDB's Python module: the installed one or the copy in Blender's wheel, without starting Blender."""
    if find_openvdb() is None:
        pytest.skip("OpenVDB's Python module is not installed: no wheel of it, or of bpy, for this Python")
    return imported()


@pytest.fixture(scope="module")
def kept_workers() -> Iterator[None]:
    """Let all runs of a module keep their workers for each other, as `keeping_workers` does for those of one shot."""
    spare: list[Member] = []
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(GraphShot.__init__, "__defaults__", (spare,))
        yield
    for one in spare:
        one.end()


@pytest.fixture(autouse=True)
def forked_workers(request: pytest.FixtureRequest, monkeypatch: pytest.MonkeyPatch) -> None:
    """Fork the workers that a test starts, except where workers are what is tested."""
    if not {"hosts", "worker"} & set(request.path.relative_to(Path(__file__).parent).parts):
        monkeypatch.setattr(member, "subprocess", SimpleNamespace(Popen=forked.start, DEVNULL=subprocess.DEVNULL))


@pytest.fixture(autouse=True)
def one_thread(request: pytest.FixtureRequest) -> Iterator[None]:
    """Compute on one thread: there are as many processes as cores. Tests with "thread" in their names have all."""
    import numba  # it looks for the folder named above when it is first imported

    numba.set_num_threads(numba.config.NUMBA_NUM_THREADS if "thread" in request.node.name else 1)
    yield
    numba.set_num_threads(1)


@pytest.fixture
def threads() -> Iterator[Callable[[int], None]]:
    """Set the number of threads of numba, for this test."""
    import numba

    before = numba.get_num_threads()
    yield numba.set_num_threads
    numba.set_num_threads(before)


@pytest.fixture
def same_on_threads(threads: Callable[[int], None]) -> Callable[[Callable], Any]:
    """Compute something on one thread and on two, see that no bit of its arrays differs, and give it."""

    def check(compute: Callable) -> Any:
        threads(1)
        one = compute()
        threads(2)
        for alone, together in zip(arrays_of(one), arrays_of(compute()), strict=True):
            assert bits_of(alone) == bits_of(together)
        return one

    return check


def bits_of(array: np.ndarray) -> tuple:
    """Type, shape and bytes of an array; of one of other objects, such as texts, these."""
    return array.dtype, array.shape, array.tolist() if array.dtype.kind == "O" else array.tobytes()


def arrays_of(value: Any) -> Iterator[np.ndarray]:
    """Give the arrays and numbers in tuples, lists and objects."""
    if isinstance(value, tuple | list):
        for each in value:
            yield from arrays_of(each)
    elif hasattr(value, "__dict__") and not isinstance(value, np.ndarray):
        yield from arrays_of([*vars(value).values()])
    else:
        yield np.asarray(value)
