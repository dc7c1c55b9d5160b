"""Arguments and options of several commands."""

from collections.abc import Callable, Mapping
from functools import partial, wraps
from importlib.util import find_spec
from pathlib import Path
from typing import TYPE_CHECKING, Any, TypedDict

import click

import hairpipe
from hairpipe.app.cli.completion import complete_graph, complete_node, complete_setting, complete_target, complete_wedge
from hairpipe.engine.worker.threading_layer import usable_cores
from hairpipe.errors import BadInput

if TYPE_CHECKING:
    from hairpipe.app.api.selection import Target
    from hairpipe.app.api.shot import Shot

EXPERIMENTS = "hairpipe.graphs.experiments"


class Engine(TypedDict):
    """Arguments of `Shot.run`: where it computes, and how much at a time."""

    jobs: int
    scans: int
    scheduler: str | None
    insecure: bool


def has_experiments() -> bool:
    """Whether this is a checkout."""
    return find_spec(EXPERIMENTS) is not None


def check_experiments(command: str) -> None:
    """Raise BadInput in a wheel, which is without experiments."""
    if not has_experiments():
        raise BadInput(f"`{command}` is not in a wheel", right="pip install -e . in a checkout")


def engine(command: Callable[..., None]) -> Callable[..., None]:
    """Add the options of an engine to a command, which gets them as one argument; a simulation takes all threads."""
    return _with_engine(command, jobs, lambda jobs: 1)


def side_by_side(command: Callable[..., None]) -> Callable[..., None]:
    """Add the same options to a command whose simulations run side by side, each on one thread."""
    return _with_engine(command, _simulations, lambda jobs: jobs)


def _with_engine(
    command: Callable[..., None], number: Callable[..., Any], scans_of: Callable[[int], int]
) -> Callable[..., None]:
    @wraps(command)
    def run(*, jobs: int, engine: str, scheduler: str | None, insecure: bool, **others: Any) -> None:
        if (engine == "dask") != (scheduler is not None):
            what = "--engine dask and --scheduler belong together"
            raise BadInput(what, right="--engine dask --scheduler tls://HOST:PORT")
        command(engine=Engine(jobs=jobs, scans=scans_of(jobs), scheduler=scheduler, insecure=insecure), **others)

    return _with_options(run, number, _engine, _scheduler, _insecure)


def shot(command: Callable[..., None]) -> Callable[..., None]:
    """Add GRAPH, --set and --cache to a command, which gets the shot that they describe as one argument."""

    @wraps(command)
    def run(*, graph: str, overrides: dict[str, str], cache: Path, **others: Any) -> None:
        command(shot=hairpipe.load(graph, parsed(overrides), cache=cache), **others)

    return _with_options(run, graph, overrides, cache)


def shot_or_wedge(command: Callable[..., None]) -> Callable[..., None]:
    """Add the same options and --wedge to a command, which gets the shot, or all variants of its wedge, likewise."""

    @wraps(command)
    def run(*, shot: "Shot", wedge: str | None, **others: Any) -> None:
        command(shot=shot if wedge is None else shot.wedge(wedge), **others)

    return shot(wedge(run))


def _with_options(command: Callable[..., None], *options: Callable[..., Any]) -> Callable[..., None]:
    for option in reversed(options):
        command = option(command)
    return command


def read_graph(ctx: click.Context, param: click.Parameter, given: Any) -> Any:
    """Read the path or name of a graph; BadInput for the text of a graph, which `hairpipe.load` accepts."""
    for name in [given] if isinstance(given, str) else given or ():
        if "\n" in name:
            raise BadInput(f"no graph '{name}'", right="a graph file, or the name of a shipped graph")
    return given


def read_target(ctx: click.Context, param: click.Parameter, text: str) -> "Target":
    from hairpipe.app.api.selection import read_target as read

    return read(text)


def read_overrides(ctx: click.Context, param: click.Parameter, given: tuple[str, ...]) -> dict[str, str]:
    """Read repeated `NODE.SETTING=VALUE`; the last value of a setting is used."""
    pairs = [text.partition("=") for text in given]
    for name, equals, _ in pairs:
        if not equals:
            raise BadInput(f"'{name}' is not an assignment", where="--set", right="NODE.SETTING=VALUE")
    return {name.strip(): value for name, _, value in pairs}


def parsed(overrides: Mapping[str, str]) -> dict[str, Any]:
    """Read the values of settings as TOML, else as texts."""
    from hairpipe.engine.file.overrides import parse_value

    return {target: parse_value(text) for target, text in overrides.items()}


def read_frames(ctx: click.Context, param: click.Parameter, text: str | None) -> tuple[int, ...] | None:
    """Read a set of frames; None where none is given."""
    from hairpipe.app.api.selection import read_frames as read

    try:
        return read(text)
    except BadInput as fault:
        raise BadInput(fault.what, where=param.opts[0], right=fault.right) from None


def read_cache(ctx: click.Context, param: click.Parameter, path: Path) -> Path:
    """Read a folder; BadInput for a path that cannot be a folder, and for the cache of an untrusted user."""
    from hairpipe.app.api.cache import open_store

    if not ctx.resilient_parsing:
        open_store(path)
    return path


graph = click.argument("graph", callback=read_graph, shell_complete=complete_graph)
graphs = click.argument("graphs", nargs=-1, metavar="[GRAPH]...", callback=read_graph, shell_complete=complete_graph)
target = click.argument("target", metavar="NODE[.OUTPUT][@FRAME]", callback=read_target, shell_complete=complete_target)
overrides = click.option(
    "--set",
    "overrides",
    multiple=True,
    metavar="NODE.SETTING=VALUE",
    callback=read_overrides,
    shell_complete=complete_setting,
    help="Setting to change for this command only; repeatable.",
)
frames = click.option(
    "--frames", metavar="1-100x2,150", callback=read_frames, help="Frames to compute; by default those of the graph."
)
only = click.option(
    "--only", metavar="1-100x2,150", callback=read_frames, help="Frames to compute now, of those of the shot."
)
to = click.option(
    "--to",
    multiple=True,
    metavar="NODE",
    shell_complete=complete_node,
    callback=lambda ctx, param, texts: tuple(name for text in texts for name in text.split()),
    help="Node to compute, or several in quotes, with its dependencies only; repeatable.",
)
wedge = click.option(
    "--wedge", metavar="WEDGE", shell_complete=complete_wedge, help="Wedge of which all variants are computed."
)
wedge_name = click.argument("name", metavar="WEDGE", shell_complete=complete_wedge)
publish_root = click.option(
    "--publish-root",
    metavar="FOLDER",
    type=click.Path(path_type=Path),
    help="Additional folder for published files, besides that of the project.",
)
cache = click.option(
    "--cache",
    envvar="HAIRPIPE_CACHE",
    show_envvar=True,
    default=Path("cache"),
    show_default="cache in the current folder",
    callback=read_cache,
    type=click.Path(path_type=Path),
    help="Folder of the cache of results.",
)
_jobs = partial(
    click.option,
    "-j",
    "--jobs",
    type=click.IntRange(1, 1024),
    metavar="N",
    default=usable_cores,
    show_default="all cores",
)
jobs = _jobs(help="Number of processes, and of threads per simulation; results do not depend on it.")
as_json = click.option("--json", "as_json", is_flag=True, help="Print a JSON document instead of text.")
as_markdown = click.option("--markdown", "as_markdown", is_flag=True, help="Print a Markdown table.")
_simulations = _jobs(help="Number of simulations side by side, each on one thread; no error depends on it.")
_engine = click.option(
    "--engine",
    type=click.Choice(["local", "dask"]),
    default="local",
    show_default=True,
    help="Engine that computes: local (this machine), dask (the workers of --scheduler).",
)
_scheduler = click.option("--scheduler", metavar="ADDRESS", help="Address of the Dask scheduler, as tls://HOST:PORT.")
_insecure = click.option(
    "--insecure", is_flag=True, help="Allow a scheduler without TLS: whoever reaches its port can run code."
)
