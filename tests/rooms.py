"""The rooms of `hairpipe/`: what each is about and how large it may be; `python -m tests.rooms` prints their counts."""

import ast
from collections import defaultdict
from pathlib import Path

from .sources import EXTENSION, HOME, SOURCES, imports_of, length_of, module_of, tree_of

BUDGETS = {
    "base": ("errors, units, files, processes: what every room may need", 1000),
    "values": ("what travels along edges", 1685),
    "geometry": ("vectors, SIMD lanes, banded systems, trees, pairs, distances", 3384),
    "body": ("skeletons, motion capture, skinning, our own bust", 1947),
    "levelset": ("level sets of bodies, baked and interpolated in time", 2597),
    "groom": ("hair at rest: seeded, grown, imported, painted, interpolated, transferred", 3143),
    "laws": ("one law a file: force, derivative, source", 1782),
    "strands": ("rod, network, chain: rows, rest shape, calibration", 2498),
    "solve": ("stages, integrators, conjugate gradients, step size, lost steps, strands at rest", 3927),
    "volume": ("hair as a continuum on grids", 795),
    "contact": ("who touches whom: search, swept collisions, active sets", 2677),
    "shot": ("scene to interactions, frame, cuts, locks", 2781),
    "particles": ("hair as loosely connected particles", 2275),
    "measure": ("metrics that a shot or `tune` uses", 1585),
    "render": ("pictures", 2830),
    "formats": ("one file a format, and their registry", 10856),
    "blender": ("programs that Blender runs: the extension, import of a shot, conversion", 2752),
    "engine": ("files, nodes, keys, store, plan, run, workers, hosts; no word of hair", 9608),
    "app": ("Python interface, command line, page, bridge, tuning, wedges, farms", 8656),
}
"""What a room is about, and its most lines of Python. A budget falls, but for a new feature."""
MOST_LINES, MOST_FILES, MOST_SINGLE, MOST_CLOSURE = 66_778, 334, 24, 105
"""Most lines and files of all rooms, files with one importer, and files that `simulate_hair` imports."""
REGISTERS = (
    *("hairpipe.nodes.", "hairpipe.app.cli.", "hairpipe.strands.registry", "hairpipe.shot.build"),
    *("hairpipe.formats.usd.check.lint", "hairpipe.formats.strand_files", "hairpipe.formats.bodies"),
)
"""Files that only list others: to be imported by one of them alone is as it should be."""
FILES = [path for path in SOURCES if path.is_relative_to(HOME / "hairpipe")]
PATHS = {module_of(path).removesuffix(".__init__"): path for path in SOURCES}


def room_of(path: Path) -> str:
    first, *inner = path.relative_to(HOME / "hairpipe").parts
    return first if inner else "base"


def lines_of_rooms() -> dict[str, int]:
    """Count the lines of Python of each room."""
    found = dict.fromkeys(BUDGETS, 0)
    for path in FILES:
        found[room_of(path)] += length_of(path)
    return found


def modules_in(path: Path) -> set[str]:
    """Name our modules that a file imports: `from hairpipe.values import Mesh` imports `hairpipe.values`."""
    names = {name if name in PATHS else name.rpartition(".")[0] for name in imports_of(path)}
    return names & PATHS.keys()


def importers() -> dict[str, set[str]]:
    """Name the modules that import each module."""
    found: dict[str, set[str]] = defaultdict(set)
    for name, path in PATHS.items():
        for target in modules_in(path):
            found[target].add(name)
    return found


def single_importers() -> dict[str, str]:
    """Name the modules that one other alone imports, unless that is a register, with their importer.

    The files of the extension of Blender are one program.
    """
    rooms = {module_of(path) for path in FILES if path.parent != EXTENSION}
    alone = {name: next(iter(users)) for name, users in importers().items() if len(users) == 1 and name in rooms}
    return {name: user for name, user in alone.items() if not user.startswith(REGISTERS)}


def arrows() -> set[tuple[str, str]]:
    """List the pairs of rooms of which one imports the other."""
    found = set()
    for path in FILES:
        for target in modules_in(path):
            if PATHS[target].is_relative_to(HOME / "hairpipe") and room_of(PATHS[target]) != room_of(path):
                found.add((room_of(path), room_of(PATHS[target])))
    return found


def closure_of(module: str) -> set[str]:
    """Name the modules that importing and calling a module may import, directly or through others."""
    found, queue = set[str](), [module]
    while queue:
        name = queue.pop()
        if name not in found:
            found.add(name)
            queue += modules_in(PATHS[name])
    return found


def single_calls() -> list[str]:
    """List the functions of five lines or fewer that are named once, in their own file."""
    found = []
    for path in FILES:
        tree = tree_of(path)
        names = [item.id for item in ast.walk(tree) if isinstance(item, ast.Name)]
        names += [item.attr for item in ast.walk(tree) if isinstance(item, ast.Attribute)]
        short = [item for item in tree.body if isinstance(item, ast.FunctionDef) and lines_in(item) <= 5]
        used = {name for user in importers()[module_of(path)] for name in imports_of(PATHS[user])}
        found += [
            f"{module_of(path)}.{item.name}"
            for item in short
            if names.count(item.name) == 1 and f"{module_of(path)}.{item.name}" not in used
        ]
    return found


def lines_in(function: ast.FunctionDef) -> int:
    """Count the lines of a function without its docstring and its decorators."""
    first = function.body[1:] if ast.get_docstring(function) else function.body
    return 1 + (function.end_lineno or 0) - first[0].lineno + 1 if first else 1


def main() -> None:
    lines = lines_of_rooms()
    files = {room: sum(room_of(path) == room for path in FILES) for room in BUDGETS}
    for room, (about, most) in BUDGETS.items():
        print(f"{room:10} {lines[room]:7,} of {most:6,} lines {files[room]:4} files   {about}")
    print(f"{'all':10} {sum(lines.values()):7,} of {MOST_LINES:6,} lines {len(FILES):4} files of {MOST_FILES}")
    print(f"files with one importer that is no register: {len(single_importers())} of {MOST_SINGLE}")
    print(f"files that simulate_hair imports: {len(closure_of('hairpipe.nodes.simulate_hair'))} of {MOST_CLOSURE}")
    print(f"arrows between {len(BUDGETS)} rooms: {len(arrows())}")
    print(f"functions of five lines or fewer that are called once, in their file: {len(single_calls())}")


if __name__ == "__main__":
    main()
