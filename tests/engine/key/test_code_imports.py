"""Which modules an import may lead to: none that can bind the name is left out of the code of a node."""

import sys
from importlib.util import resolve_name

import pytest

from hairpipe.engine.code import CodeReader
from hairpipe.plain_file import stamp_of


@pytest.fixture
def write(tmp_path, monkeypatch):
    """Write modules that can be imported, by path and text."""
    monkeypatch.setattr(sys, "path", [*sys.path, str(tmp_path)])

    def write(files):
        for name, text in files.items():
            (tmp_path / name).parent.mkdir(parents=True, exist_ok=True)
            (tmp_path / name).write_text(text)
        return tmp_path

    return write


def modules(name="bake", folder=None):
    parts = CodeReader(lambda name, make: make(), folder).code_of(name).parts
    return {part for part in parts if not part.endswith(")")} - {name}


@pytest.mark.parametrize(
    "text",
    [
        "try:\n    from fastlib import factor\nexcept ImportError:\n    factor = 1.0\n",
        "import fastlib as factor\n",
        "from fastlib import *\n",
        "def __getattr__(name):\n    from fastlib import factor\n    return factor\n",
        "if FAST:\n    from fastlib import factor\nelse:\n    globals()['factor'] = 1.0\n",
    ],
)
def test_a_module_counts_and_all_that_may_bind_its_names(write, text):
    write({"bake.py": "from compat import factor\n", "compat.py": text, "fastlib.py": "factor = 2.0\n"})
    assert modules() == {"compat", "fastlib"}


START = "def start():\n    from engine import core\n    return core\n"
DEEP = {"pq2/__init__.py": "K = 1\n", "pq2/sub/__init__.py": "", "pq2/sub/deep.py": ""}
OUTSIDE = "try:\n    from . import tally\nexcept ImportError:\n    import tally\n"
IMPORTS = {
    "a submodule in the place of a name, once somebody imports it": (
        {"bake.py": "from pk import core\n", "pk/core.py": "", "engine.py": "core = 1\n", "pk/__init__.py": START},
        {"pk", "pk.core", "engine"},
    ),
    "a submodule and a name": (
        {"bake.py": "from pk import core\n", "pk/core.py": "", "pk/__init__.py": "core = 1\n"},
        {"pk", "pk.core"},
    ),
    "a star, for modules that `__all__` lists": (
        {"bake.py": "from pk import *\n", "pk/__init__.py": "__all__ = ['core']\n", "pk/core.py": ""},
        {"pk", "pk.core"},
    ),
    "folders within folders": (
        {"bake.py": "from studio.tools import soft\n", "studio/tools/soft.py": ""},
        {"studio.tools.soft"},
    ),
    "a plain import": (DEEP | {"bake.py": "import pq2.sub.deep\n"}, {"pq2", "pq2.sub", "pq2.sub.deep"}),
    "a plain import as another name": (DEEP | {"bake.py": "import pq2.sub.deep as deep\n"}, {"pq2.sub.deep"}),
    "a relative import outside of a package, and another": ({"bake.py": OUTSIDE, "tally.py": ""}, {"tally"}),
    "a relative import outside of a package": ({"bake.py": "def bake():\n    from . import nothing\n"}, set()),
}


@pytest.mark.parametrize("name", IMPORTS)
def test_an_import_leads_to_all_modules_that_may_bind_its_names(write, name):
    files, found = IMPORTS[name]
    write(files)
    assert modules() == found and "studio" not in sys.modules


@pytest.mark.parametrize("text", ["from tools import soft\n", "from tools.soft import f\n", "import tools.soft\n"])
def test_a_folder_without_a_file_of_its_own_has_modules_too(write, text):
    folder = write({"nodes/bake.py": text, "nodes/tools/soft.py": "def f():\n    return 1\n"}) / "nodes"
    assert modules(folder=folder) == {"tools.soft"}


@pytest.mark.parametrize(
    ("file", "text", "far"),
    [
        ("pk/bake.py", "from .core import f\n", "pk.core"),
        ("pk/bake/__init__.py", "from . import inner\n", "pk.bake.inner"),
        ("pk/bake/__init__.py", "from .inner import f\n", "pk.bake.inner"),
        ("pk/bake/__init__.py", "from .. import core\n", "pk.core"),
        ("pk/bake/__init__.py", "from ..core import f\n", "pk.core"),
        ("pk/deep/bake.py", "from ..core import f\n", "pk.core"),
        ("pk/deep/bake.py", "from .. import core\n", "pk.core"),
    ],
)
def test_a_relative_import_leads_where_python_goes(write, file, text, far):
    """It goes up from the package of a module; a package is its own."""
    name = file.removesuffix(".py").removesuffix("/__init__").replace("/", ".")
    write({f"{path}.py": "" for path in ("pk/__init__", "pk/core", "pk/deep/__init__")})
    write({"pk/bake/inner.py": ""} | {file: text})
    package = name if file.endswith("__init__.py") else name.rpartition(".")[0]
    _, target, _, imported = text.split()
    found = resolve_name(target, package)
    assert far in (found, f"{found}.{imported}") and {found, far} <= modules(name) | {name}


def test_names_that_are_not_modules_are_left_out(write):
    write(
        {"bake.py": "from pk import f\nfrom pk.core import g\n", "pk/__init__.py": "f = 1\n", "pk/core.py": "g = 1\n"}
    )
    parts = CodeReader(lambda name, make: make()).code_of("bake").parts
    versions = {part for part in parts if part.endswith("(version)")}
    assert versions == {"numba (version)", "numpy (version)", "scipy (version)"}


def test_files_that_were_read_have_stamps(write):
    """A run compares them with the files that its workers import."""
    folder = write({"bake.py": "import pk.core\n", "pk/__init__.py": "", "pk/core.py": ""})
    reader = CodeReader(lambda name, make: make())
    reader.code_of("bake")
    files = [folder / "bake.py", folder / "pk" / "__init__.py", folder / "pk" / "core.py"]
    assert reader.stamps == {str(path): stamp_of(str(path)) for path in files}


def test_a_compiled_module_counts_by_its_bytes(write):
    folder = write({"nodes/bake.py": "import fast\n"}) / "nodes"
    found = []
    for data in (b"one", b"two", b"one"):
        (folder / "fast.abi3.so").write_bytes(data)
        found.append(CodeReader(lambda name, make: make(), folder).code_of("bake"))
    assert "fast" in found[0].parts and "fast (version)" not in found[0].parts
    assert found[0].digest == found[2].digest != found[1].digest
