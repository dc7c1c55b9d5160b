"""Which modules an import may lead to: none that can bind the name is left out of the code of a node."""

import sys

import pytest

from hairpipe.graph.key.code import CodeReader


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
    return {part for part in parts if not part.endswith(" (version)")} - {name}


@pytest.mark.parametrize(
    "text",
    [
        "try:\n    from fastlib import factor\nexcept ImportError:\n    def factor():\n        return 1.0\n",
        "try:\n    from fastlib import factor\nexcept ImportError:\n    class factor:\n        pass\n",
        "from fastlib import factor\nif factor is None:\n    factor = 1.0\n",
        "from fastlib import factor\ntry:\n    pass\nexcept OSError as factor:\n    pass\n",
        "from fastlib import factor\nmatch 1:\n    case [*factor]:\n        pass\n",
        "from fastlib import factor\ndef slower():\n    global factor\n    factor = 1.0\n",
        "import fastlib as factor\n",
        "from fastlib import factor\ndef slower(by=(factor := 1.0)):\n    pass\n",
        "from fastlib import factor\n@print(factor := 1.0)\nclass Slower:\n    pass\n",
        "def __getattr__(name):\n    from fastlib import factor\n    return factor\n",
    ],
)
def test_a_module_that_may_bind_the_name_itself_counts(write, text):
    write({"bake.py": "from compat import factor\n", "compat.py": text, "fastlib.py": "factor = 2.0\n"})
    assert modules() == {"compat", "fastlib"}


@pytest.mark.parametrize(
    "text",
    [
        "try:\n    from .fast import k\nexcept ImportError:\n    from .slow import k\n",
        "if FAST:\n    from .fast import k\nelse:\n    from .slow import k\n",
        "from .fast import k\nfrom .slow import k\n",
        "from .fast import k\nfrom .slow import *\n",
    ],
)
def test_each_of_two_origins_counts(write, text):
    write({"bake.py": "from pq import k\n", "pq/__init__.py": text, "pq/fast.py": "k = 1\n", "pq/slow.py": "k = 2\n"})
    assert modules() == {"pq", "pq.fast", "pq.slow"}


def test_one_import_under_a_condition_is_not_certain(write):
    write(
        {
            "bake.py": "from pq import k\n",
            "pq/__init__.py": "if FAST:\n    from .fast import k\nelse:\n    globals()['k'] = 1\n",
            "pq/fast.py": "k = 1\n",
        }
    )
    assert modules() == {"pq", "pq.fast"}


def test_a_lone_re_export_leads_past_what_gathers_it(write):
    write(
        {
            "bake.py": "from pq import k\n",
            "pq/__init__.py": "from .fast import k\nfrom .slow import other\ndef f():\n    from .slow import k\n",
            "pq/fast.py": "k = 1\n",
            "pq/slow.py": "k = other = 2\n",
        }
    )
    assert modules() == {"pq.fast"}


def test_an_import_within_a_function_re_exports_nothing(write):
    write(
        {
            "bake.py": "from pk import core\n",
            "pk/__init__.py": "def start():\n    from engine import core\n    return core\n",
            "pk/core.py": "",
            "engine.py": "core = 1\n",
        }
    )
    assert modules() == {"pk.core"}


def test_a_submodule_may_take_the_place_of_a_name(write):
    """As soon as somebody imports it."""
    files = {"bake.py": "from pk import core\n", "pk/core.py": "", "engine.py": "core = 1\n"}
    write(files | {"pk/__init__.py": "from engine import core\n"})
    assert modules() == {"pk.core", "engine"}
    write({"pk/__init__.py": "core = 1\n"})
    assert modules() == {"pk.core", "pk"}


def test_a_star_import_takes_the_submodules_that_are_listed(write):
    write({"bake.py": "from pk import *\n", "pk/__init__.py": "__all__ = ['core']\n", "pk/core.py": ""})
    assert modules() == {"pk", "pk.core"}
    write({"pk/__init__.py": "x = 1\n"})
    assert modules() == {"pk"}


@pytest.mark.parametrize("text", ["from tools import soft\n", "from tools.soft import f\n", "import tools.soft\n"])
def test_a_folder_without_a_file_of_its_own_has_modules_too(write, text):
    folder = write({"nodes/bake.py": text, "nodes/tools/soft.py": "def f():\n    return 1\n"}) / "nodes"
    assert modules(folder=folder) == {"tools.soft"}


def test_folders_within_folders_are_found_without_an_import(write):
    write({"bake.py": "from studio.tools import soft\n", "studio/tools/soft.py": ""})
    assert modules() == {"studio.tools.soft"}
    assert "studio" not in sys.modules


def test_what_a_plain_import_binds_counts(write):
    files = {"pq2/__init__.py": "K = 1\n", "pq2/sub/__init__.py": "", "pq2/sub/deep.py": ""}
    write(files | {"bake.py": "import pq2.sub.deep\n"})
    assert modules() == {"pq2", "pq2.sub", "pq2.sub.deep"}
    write({"bake.py": "import pq2.sub.deep as deep\n"})
    assert modules() == {"pq2.sub.deep"}


def test_a_relative_import_outside_of_a_package_leads_nowhere(write):
    write({"bake.py": "try:\n    from . import tally\nexcept ImportError:\n    import tally\n", "tally.py": ""})
    assert modules() == {"tally"}
    write({"bake.py": "def bake():\n    from . import nothing\n"})
    assert modules() == set()


def test_a_compiled_module_counts_by_its_bytes(write):
    folder = write({"nodes/bake.py": "import fast\n"}) / "nodes"
    found = []
    for data in (b"one", b"two", b"one"):
        (folder / "fast.abi3.so").write_bytes(data)
        found.append(CodeReader(lambda name, make: make(), folder).code_of("bake"))
    assert "fast" in found[0].parts and "fast (version)" not in found[0].parts
    assert found[0].digest == found[2].digest != found[1].digest
