"""Compilation at the first use of a graph: processor seconds of a first step with and without kernels."""

import resource
import subprocess
import tempfile
from collections import Counter
from collections.abc import Iterator, Mapping
from pathlib import Path

from hairpipe.child import command, environment
from hairpipe.engine.file.load import load_graph
from hairpipe.engine.worker.machine_code import FOLDER_DIGITS
from hairpipe.errors import BadInput
from hairpipe.graphs.experiments.bench.report import Case, Report, make_report

HAIR = "hair"
"""Name of the scan in our graphs."""
_MAIN = "from hairpipe.cli import main; sys.argv[1:] = {!r}; main()"


def measure_first_use(graph_path: Path, overrides: Mapping[str, str], node: str = HAIR) -> Report:
    """Measure the first two frames of a node of a graph, in temporary folders; BadInput if they fail.

    The first frame of a simulation is its start: kernels of a step are compiled for the second frame.
    """
    begin = load_graph(graph_path, overrides).begin
    frames = f"{begin}-{begin + 1}"
    words = ["run", str(graph_path), "--to", node, "--frames", frames, "-q"]
    words += [word for target, value in overrides.items() for word in ("--set", f"{target}={value}")]
    with tempfile.TemporaryDirectory() as folder:
        variables = environment() | {"NUMBA_CACHE_DIR": folder}
        spent = []
        for cache in ("first", "second"):
            begun = children_seconds()
            code = _MAIN.format([*words, "--cache", str(Path(folder, cache))])
            if subprocess.run(command(code), env=variables, stdout=2).returncode:
                raise BadInput(
                    f"'{node}' does not compute frames {frames}", where=graph_path, right="a graph that runs"
                )
            spent.append(children_seconds() - begun)
        kernels = Counter(kernels_in(Path(folder, "hairpipe")))
    cold, warm = spent
    seconds: Case = {"without kernels [processor s]": cold, "with kernels [processor s]": warm}
    numbers: Case = {"kernels": sum(kernels.values()), "functions": len(kernels)}
    several: list[Case] = [{"function": name, "kernels": count} for name, count in kernels.most_common() if count > 1]
    return make_report(__name__, {"first use": [seconds | numbers], "functions of several kernels": several})


def kernels_in(folder: Path) -> Iterator[str]:
    """List the functions, module and name, of the kernels in a folder."""
    for path in sorted(folder.glob("*/*.nbc")):
        function = path.name.partition(".")[2].rpartition("-")[0]
        yield f"{path.parent.name[: -FOLDER_DIGITS - 1]}.{function}"


def children_seconds() -> float:
    """Return processor seconds of ended child processes, with their descendants [s]."""
    children = resource.getrusage(resource.RUSAGE_CHILDREN)
    return children.ru_utime + children.ru_stime
