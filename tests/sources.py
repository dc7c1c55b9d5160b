"""Our sources: which files there are, and what each imports."""

import ast
from functools import cache
from pathlib import Path

HOME = Path(__file__).resolve().parents[1]
SOURCES = sorted(path for room in ("hairpipe", "nodes", "graphs", "docs") for path in (HOME / room).rglob("*.py"))
TESTS = sorted((HOME / "tests").rglob("*.py"))
EXTENSION = HOME / "hairpipe/blender/extension"
"""Files that Blender runs, under a name of its own, and that nothing imports."""
PACKAGES = sorted(p.parent.relative_to(HOME) for p in SOURCES if p.name == "__init__.py" and p.parent != EXTENSION)


@cache
def tree_of(path: Path) -> ast.Module:
    """Parse a file, once for all laws."""
    return ast.parse(path.read_text(encoding="utf-8"), str(path))


def name_of(path: Path) -> str:
    return path.relative_to(HOME).as_posix()


@cache
def imports_of(path: Path) -> list[str]:
    """Name the modules that a file imports, those in functions and those by `importlib` too."""
    found = []
    for item in ast.walk(tree_of(path)):
        if isinstance(item, ast.Import):
            found += [alias.name for alias in item.names]
        elif isinstance(item, ast.ImportFrom):
            assert item.level == (path.parent == EXTENSION and item.level), f"{path}: relative import"
            home = (
                ".".join(("hairpipe.blender.extension", item.module or "")).rstrip(".") if item.level else item.module
            )
            found += [f"{home}.{alias.name}" for alias in item.names]
        elif isinstance(item, ast.Call) and ast.unparse(item.func).endswith(("import_module", "find_spec")):
            found += [value.value for value in item.args if isinstance(value, ast.Constant) and value.value]
    return found


def length_of(path: Path) -> int:
    return len(path.read_text(encoding="utf-8").splitlines())


def module_of(path: Path) -> str:
    """Name the module of a file as it is imported."""
    name = ".".join(path.relative_to(HOME).with_suffix("").parts)
    return name if path.is_relative_to(HOME / "hairpipe") else f"hairpipe.{name}"
