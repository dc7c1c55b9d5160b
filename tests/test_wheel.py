"""What a wheel holds: the product, and nothing that serves experiments alone."""

import ast
import re
from collections.abc import Iterator
from pathlib import Path

from .sources import EXTENSION, HOME, SOURCES, imports_of, module_of, name_of, tree_of


def is_in_wheel(path: Path) -> bool:
    """Whether a module is installed: those of graphs/experiments, and programs that wrote the assets, are not.

    The extension of Blender is installed as files.
    """
    return (
        path.parent != EXTENSION and name_of(path).startswith(("hairpipe/", "nodes/"))
    ) or path == HOME / "graphs/__init__.py"


def quoted_in(path: Path) -> Iterator[str]:
    """Name the modules of ours that a file names in texts: code for another process, and tunings of models."""
    texts = (item.value for item in ast.walk(tree_of(path)) if isinstance(item, ast.Constant))
    yield from (name for text in texts if isinstance(text, str) for name in re.findall(r"hairpipe(?:\.\w+)+", text))


def test_no_module_of_the_wheel_serves_experiments_alone():
    """The product is what the command line, `import hairpipe` and the node types import, directly or through others."""
    paths = {module_of(path).removesuffix(".__init__"): path for path in SOURCES if is_in_wheel(path)}
    queue = [name for name in paths if name == "hairpipe" or name.startswith(("hairpipe.app.cli", "hairpipe.nodes"))]
    reached: set[str] = set()
    while queue:
        name = queue.pop()
        if name in paths and name not in reached:
            reached.add(name)
            targets = [name, *imports_of(paths[name]), *quoted_in(paths[name])]
            queue += [*targets, *(target.rpartition(".")[0] for target in targets)]
    assert not sorted(paths.keys() - reached)
