"""Code digests: what of the source counts, and whose."""

import sys

import pytest

from hairpipe.graph.code import CodeReader

FILES = {
    "shop/__init__.py": "from shop.bread import bake\nfrom shop.milk import pour\nOPEN = 8\n",
    "shop/bread.py": "import numpy\nfrom . import oven\ndef bake():\n    return oven.heat()\n",
    "shop/oven.py": "def heat():\n    from shop.wood import burn\n    return burn()\n",
    "shop/wood.py": "from hairpipe.graph import node\nfrom hairpipe.units import Metres\ndef burn():\n    return 1\n",
    "shop/milk.py": "def pour():\n    return 2\n",
    "shop/till.py": "from shop import OPEN, milk\n",
    "shop/round.py": "from shop.about import x\n",
    "shop/about.py": "import shop.round\nx = 1\n",
    "shop/all.py": "from shop.milk import *\n",
    "breakfast.py": '"""Eat."""\nfrom shop import bake\ndef breakfast():\n    """Serve."""\n    return bake()\n',
}


@pytest.fixture
def shop(tmp_path, monkeypatch):
    for name, text in FILES.items():
        (tmp_path / name).parent.mkdir(exist_ok=True)
        (tmp_path / name).write_text(text)
    monkeypatch.setattr(sys, "path", [*sys.path, str(tmp_path)])
    return tmp_path


def code_of(module):
    return CodeReader(lambda name, make: make()).code_of(module)


def modules(name):
    return {part for part in code_of(name).parts if not part.endswith(" (version)")}


def test_imports_are_followed_to_who_binds_the_name(shop):
    """Through the re-export, a relative import and one inside a function; not to what the package gathers besides."""
    assert modules("breakfast") == {"breakfast", "shop.bread", "shop.oven", "shop.wood", "hairpipe.units"}
    assert modules("shop.till") == {
        "shop.till",
        "shop",
        "shop.bread",
        "shop.milk",
        "shop.oven",
        "shop.wood",
        "hairpipe.units",
    }
    assert modules("shop.all") == {"shop.all", "shop.milk"}


def test_a_file_of_node_types_is_meant_by_its_name_whatever_is_installed(tmp_path):
    """As it is when it is loaded; also where another folder has one of that name."""
    for folder, text in (("one", "x = 1\n"), ("two", "x = 2\n")):
        (tmp_path / folder).mkdir()
        (tmp_path / folder / "pluggy.py").write_text(text)
    digests = {
        CodeReader(lambda name, make: make(), folder).code_of("pluggy").digest
        for folder in (None, tmp_path / "one", tmp_path / "two")
    }
    assert len(digests) == 3


def test_circular_imports_end(shop):
    assert modules("shop.round") == {"shop.round", "shop.about"}


def test_nothing_is_imported_to_find_out(shop):
    code_of("breakfast")
    assert "shop" not in sys.modules and "breakfast" not in sys.modules


@pytest.mark.parametrize(
    ("file", "old", "new", "same"),
    [
        ("breakfast.py", '"""Serve."""', '"""Serve it hot."""', True),
        ("breakfast.py", '"""Eat."""\n', "# Eat\n\n\n", True),
        ("breakfast.py", "return bake()", "return (bake( ))  # yes", True),
        ("breakfast.py", "return bake()", "return bake() + 1", False),
        ("breakfast.py", '    """Serve."""', '    what = """Serve."""', False),
        ("shop/wood.py", "return 1", "return 1.0", False),
        ("shop/milk.py", "return 2", "return 3", True),
        ("shop/__init__.py", "OPEN = 8", "OPEN = 9", True),
        ("shop/__init__.py", "from shop.bread import bake", "from shop.milk import pour as bake", False),
    ],
)
def test_what_changes_the_digest(shop, file, old, new, same):
    before = code_of("breakfast").digest
    text = (shop / file).read_text()
    assert old in text
    (shop / file).write_text(text.replace(old, new))
    assert (code_of("breakfast").digest == before) == same


def test_line_ends_do_not_count(shop):
    before = code_of("breakfast").digest
    path = shop / "breakfast.py"
    path.write_bytes(path.read_bytes().replace(b"\n", b"\r\n"))
    assert code_of("breakfast").digest == before


def test_versions_of_the_numeric_libraries_count(shop, monkeypatch):
    from hairpipe.graph import code

    before = code_of("shop.milk").digest
    monkeypatch.setattr(code, "version", lambda name: "9.9" if name == "numba" else "1")
    assert code_of("shop.milk").digest != before
    assert {"numpy (version)", "scipy (version)", "numba (version)"} <= code_of("shop.milk").parts.keys()
