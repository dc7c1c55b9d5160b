"""What a wheel holds: the product, and nothing that serves experiments alone."""

import ast
import re
import tomllib
from collections.abc import Iterator
from pathlib import Path

from .sources import HOME, PACKAGES, SOURCES, imports_of, length_of, module_of, tree_of

MOST_LINES_OF_THE_WHEEL = 54_600
"""Of `hairpipe/`; nodes and graphs apart."""


def is_in_wheel(path: Path) -> bool:
    """Whether a file is installed: those of graphs/experiments, and programs that wrote the assets, are not."""
    return not path.is_relative_to(HOME / "graphs") or (path.name == "__init__.py" and path.parent == HOME / "graphs")


def quoted_in(path: Path) -> Iterator[str]:
    """Name the modules of ours that a file names in texts: code for another process, and tunings of models."""
    texts = (item.value for item in ast.walk(tree_of(path)) if isinstance(item, ast.Constant))
    yield from (name for text in texts if isinstance(text, str) for name in re.findall(r"hairpipe(?:\.\w+)+", text))


def test_a_wheel_has_every_package():
    with (HOME / "pyproject.toml").open("rb") as file:
        listed = tomllib.load(file)["tool"]["setuptools"]["packages"]
    held = [path for path in PACKAGES if "experiments" not in path.parts]
    names = {".".join(("hairpipe", *path.parts[path.parts[0] == "hairpipe" :])) for path in held}
    assert sorted(listed) == sorted(names)


def test_no_module_of_the_wheel_serves_experiments_alone():
    """The product is what the command line, `import hairpipe` and the node types import, directly or through others."""
    paths = {module_of(path).removesuffix(".__init__"): path for path in SOURCES if is_in_wheel(path)}
    queue = [name for name in paths if name == "hairpipe" or name.startswith(("hairpipe.cli", "hairpipe.nodes"))]
    reached: set[str] = set()
    while queue:
        name = queue.pop()
        if name in paths and name not in reached:
            reached.add(name)
            targets = [name, *imports_of(paths[name]), *quoted_in(paths[name])]
            queue += [*targets, *(target.rpartition(".")[0] for target in targets)]
    assert not sorted(paths.keys() - reached)


def test_the_wheel_is_small():
    lines = sum(length_of(path) for path in SOURCES if path.is_relative_to(HOME / "hairpipe"))
    assert lines <= MOST_LINES_OF_THE_WHEEL
