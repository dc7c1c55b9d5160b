"""Our sources: which files there are, and what each imports."""

import ast
from collections.abc import Iterator
from pathlib import Path

HOME = Path(__file__).resolve().parents[1]
SOURCES = sorted(path for room in ("hairpipe", "nodes", "graphs", "docs") for path in (HOME / room).rglob("*.py"))
TESTS = sorted((HOME / "tests").rglob("*.py"))
PACKAGES = sorted(path.parent.relative_to(HOME) for path in SOURCES if path.name == "__init__.py")


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


def length_of(path: Path) -> int:
    return len(path.read_text(encoding="utf-8").splitlines())


def module_of(path: Path) -> str:
    """Name the module of a file as it is imported."""
    name = ".".join(path.relative_to(HOME).with_suffix("").parts)
    return name if path.is_relative_to(HOME / "hairpipe") else f"hairpipe.{name}"
