"""Code digests: what of the source counts, and whose."""

import importlib
import os
import sys

import pytest

from hairpipe.engine import code
from hairpipe.engine.code import CodeReader, read_source, version
from hairpipe.engine.store import fingerprint
from hairpipe.errors import BadInput

FILES = {
    "shop/__init__.py": "from shop.bread import bake\nfrom shop.milk import pour\nOPEN = 8\n",
    "shop/bread.py": "import numpy\nfrom . import oven\ndef bake():\n    return oven.heat()\n",
    "shop/oven.py": "def heat():\n    from shop.wood import burn\n    return burn()\n",
    "shop/wood.py": "from hairpipe.engine import node\nfrom hairpipe.units import Metres\ndef burn():\n    return 1\n",
    "shop/milk.py": "def pour():\n    return 2\n",
    "shop/till.py": "from shop import OPEN, milk\n",
    "shop/round.py": "from shop.about import x\n",
    "shop/about.py": "from shop import round\nx = 1\n",
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
    return {part for part in code_of(name).parts if not part.endswith(")")}


def test_modules_count_with_all_that_they_import(shop):
    """Through a package that re-exports, a relative import and one inside a function; not through the engine."""
    gathered = {"shop", "shop.bread", "shop.milk", "shop.oven", "shop.wood", "hairpipe.units"}
    assert modules("breakfast") == gathered | {"breakfast"}
    assert modules("shop.till") == gathered | {"shop.till"}
    assert modules("shop.bread") == gathered, "a relative import of a module leads to its package, too"
    assert modules("shop.all") == {"shop.all", "shop.milk"}


def test_a_file_of_node_types_is_meant_by_its_name_whatever_is_installed(tmp_path, monkeypatch):
    """As it is when it is loaded; also where another folder has one of that name."""
    for folder, text in (("one", "x = 1\n"), ("two", "x = 2\n")):
        (tmp_path / folder).mkdir()
        (tmp_path / folder / "pluggy.py").write_text(text)
    monkeypatch.setenv("HAIRPIPE_TRUST", os.pathsep.join([str(tmp_path / "one"), str(tmp_path / "two")]))
    digests = {
        CodeReader(lambda name, make: make(), folder).code_of("pluggy").digest
        for folder in (None, tmp_path / "one", tmp_path / "two")
    }
    assert len(digests) == 3


def test_circular_imports_end(shop):
    assert {"shop.round", "shop.about"} < modules("shop.round") == modules("shop.about")


def test_nothing_is_imported_to_find_out(shop):
    code_of("breakfast")
    assert "shop" not in sys.modules and "breakfast" not in sys.modules


def test_a_file_is_read_once_while_it_is_provably_unchanged(shop, monkeypatch):
    """Its bytes change, but not size and time of modification: the time of its status does, which no user can set."""
    read, path = [], shop / "breakfast.py"
    monkeypatch.setattr(code, "read_source", lambda data, name: read.append(name) or read_source(data, name))
    for _ in range(2):
        code_of("breakfast")
    assert read.count(str(path)) == 2, "it has just been written"
    monkeypatch.setattr(fingerprint, "SETTLED", -(10**18))
    read.clear()
    before, status = code_of("breakfast").digest, path.stat()
    assert code_of("breakfast").digest == before and read.count(str(path)) == 1
    path.write_text(FILES["breakfast.py"].replace("bake()", "cake()"))
    os.utime(path, ns=(status.st_atime_ns, status.st_mtime_ns))
    assert path.stat().st_size == status.st_size
    assert code_of("breakfast").digest != before and read.count(str(path)) == 2


@pytest.mark.parametrize(
    ("file", "old", "new", "same"),
    [
        ("breakfast.py", '"""Serve."""', '"""Serve it hot."""', True),
        ("breakfast.py", "\n", "\r\n", True),
        ("breakfast.py", '"""Eat."""\n', "# Eat\n\n\n", True),
        ("breakfast.py", "return bake()", "return (bake( ))  # yes", True),
        ("breakfast.py", "return bake()", "return bake() + 1", False),
        ("breakfast.py", '    """Serve."""', '    what = """Serve."""', False),
        ("shop/wood.py", "return 1", "return 1.0", False),
        ("shop/milk.py", "return 2", "return 3", False),
        ("shop/till.py", "milk", "milk as cream", True),
        ("shop/__init__.py", "OPEN = 8", "OPEN = 9", False),
        ("shop/__init__.py", "from shop.bread import bake", "from shop.milk import pour as bake", False),
    ],
)
def test_digest_depends_on_code_and_imports(shop, file, old, new, same):
    before = code_of("breakfast").digest
    text = (shop / file).read_text()
    assert old in text
    (shop / file).write_bytes(text.replace(old, new).encode())
    assert (code_of("breakfast").digest == before) == same


def test_versions_of_the_numeric_libraries_and_the_class_of_the_processor_count(shop, monkeypatch):
    before = code_of("shop.milk")
    monkeypatch.setattr(code, "version", lambda name: "9.9" if name == "numba" else "1")
    versions = code_of("shop.milk")
    monkeypatch.setattr(code, "processor_class", lambda: "z80")
    found = code_of("shop.milk")
    assert len({before.digest, versions.digest, found.digest}) == 3
    assert {"numpy (version)", "scipy (version)", "numba (version)"} <= found.parts.keys()
    assert found.parts["processor (class)"] == "z80"


@pytest.fixture
def installed(shop):
    """A folder of installed libraries; what is said of them is not remembered beyond the test."""
    folder = shop / "site-packages"
    folder.mkdir()
    sys.path.append(str(folder))
    known = (version, code.providers)
    yield folder
    for each in known:
        each.cache_clear()


def install(folder, version):
    """Install a library that is imported as `yawl` but called `PyYawl`."""
    for old in folder.glob("*.dist-info"):
        old.rename(folder / f"PyYawl-{version}.dist-info")
    about = folder / f"PyYawl-{version}.dist-info"
    about.mkdir(exist_ok=True)
    (about / "METADATA").write_text(f"Metadata-Version: 2.1\nName: PyYawl\nVersion: {version}\n")
    (about / "RECORD").write_text("yawl/__init__.py,,\n")
    importlib.invalidate_caches()
    code.version.cache_clear()
    code.providers.cache_clear()


def test_a_library_may_have_another_name_than_its_distribution(shop, installed):
    (installed / "yawl").mkdir()
    (installed / "yawl" / "__init__.py").write_text("x = 1\n")
    (shop / "breakfast.py").write_text("import yawl\n")
    install(installed, "1.0")
    assert code_of("breakfast").parts["yawl (version)"] == "PyYawl 1.0"
    install(installed, "1.1")
    assert code_of("breakfast").parts["yawl (version)"] == "PyYawl 1.1"
    assert version("no_such_library") == "none"


@pytest.mark.parametrize(("node", "counts"), [("export_usd", True), ("bake_levelset", False)])
def test_the_version_of_usd_counts_for_who_writes_with_it(node, counts):
    assert ("pxr (version)" in code_of(f"hairpipe.nodes.{node}").parts) == counts


def test_a_package_without_a_version_is_identified_by_its_code(shop, installed):
    (installed / "yawl.py").write_text("x = 1\n")
    (shop / "breakfast.py").write_text("import yawl\n")
    assert modules("breakfast") == {"breakfast", "yawl"}


def test_distributions_are_asked_only_where_no_name_fits(monkeypatch):
    monkeypatch.setattr(code, "providers", None)
    version.cache_clear()
    assert version("numpy") != "none" and version("no_such_library") == "none"


@pytest.mark.parametrize(
    ("data", "place", "reported"),
    [(b"x = 1\nif x\n", ":2: ", "expected ':'"), (b"x = '\xe9'\n", ":1: ", "utf-8"), (b"x = 1\0\n", "", "null byte")],
)
def test_a_file_that_python_cannot_read_is_named(shop, data, place, reported):
    (shop / "shop" / "wood.py").write_bytes(data)
    with pytest.raises(BadInput, match=f"cannot be read: .*{reported}") as caught:
        code_of("breakfast")
    assert str(caught.value).startswith(str(shop / "shop" / "wood.py") + place)


def test_a_file_that_may_not_be_read_is_named(shop, monkeypatch):
    def refuse(path):
        raise PermissionError(13, "Permission denied", str(path))

    monkeypatch.setattr(code, "stamp_of", refuse)
    with pytest.raises(BadInput, match=f"{shop / 'breakfast.py'}: cannot be read: Permission denied"):
        code_of("breakfast")


def test_modules_without_a_digest_and_without_a_file_are_named(shop):
    reader = CodeReader(lambda name, make: make())
    with pytest.raises(ValueError, match="json is not first-party"):
        reader.own_digest("json")
    with pytest.raises(ValueError, match="absent_module has no file"):
        reader.file_of("absent_module")
