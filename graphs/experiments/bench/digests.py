"""Digests of the values of small scenes, of every model, scheme and precision: equal before and after a refactoring."""

import dataclasses
import tempfile
from collections.abc import Iterator, Sequence
from hashlib import blake2b
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

import hairpipe
from hairpipe.errors import BadInput
from hairpipe.graphs.experiments.bench.report import Case, Echo, Report, make_report

GRAPHS = Path(__file__).parents[2]
DIGEST_BYTES = 10


class Scene(NamedTuple):
    """Nodes of a graph, whose values at the last of some frames are compared, with changed settings."""

    graph: str
    frames: str
    nodes: tuple[str, ...]
    changed: dict[str, Any]


def paper(**hair: Any) -> Scene:
    """Return 200 hairs of Table 2 of Selle, Lentine, Fedkiw 2008 with changed settings of the hair."""
    changed = {"groom.strands": 200} | {f"hair.{setting}": value for setting, value in hair.items()}
    return Scene("paper/long_straight_5000", "1001-1004", ("hair",), changed)


SCENES = {
    "demo": Scene("demo", "1001-1012", ("surface", "hair", "picture", "vdb"), {}),
    "tuft": Scene("experiments/tuft", "1-13", ("plain", "ours", "touching"), {}),
    "curls": Scene("experiments/curls", "1-13", ("free", "folds", "nine_steps"), {}),
    "torus": Scene("experiments/torus", "0-12", ("selected", "edges", "faces"), {}),
    "clash": Scene("experiments/stability_contact", "1", ("body", "sweep", "nine"), {}),
    "cut": Scene("experiments/cut", "1-19", ("hair",), {}),
    "wind": Scene("experiments/wind", "1001-1004", ("bare", "shielded"), {"groom.strands": 200}),
    "sag free": Scene("experiments/sag_free", "1-3", ("curl_free", "curl_rod", "long_settles", "settled_free"), {}),
    "target": Scene("experiments/target", "1001-1003", ("hair", "density"), {"groom.strands": 200}),
    "shell": Scene("experiments/shell", "0-6", ("selected",), {}),
    "style": Scene("styles", "1001-1004", ("hair", "impulse"), {}),
    "guides": Scene("guides", "1001-1003", ("hair", "dense"), {}),
    "network": paper(),
    "rod": paper(model="rod"),
    "chain": Scene("experiments/tuft", "1-7", ("ours",), {"ours.model": "chain"}),
    "network, double": paper(precision="double"),
    "network, single": paper(precision="single"),
    "rod, double": paper(model="rod", precision="double"),
    "rod, single": paper(model="rod", precision="single"),
    "network, BDF2": paper(scheme="bdf2"),
    "rod, BDF2": paper(model="rod", scheme="bdf2"),
    "network, backward Euler": paper(scheme="backward_euler"),
    "network, nine steps": paper(scheme="nine_steps"),
    "rod, backward Euler": paper(model="rod", scheme="backward_euler"),
    "network, impulses pair by pair": paper(**{"collisions.solver": "sweep"}),
    "volume": Scene(
        "volume/head", "1001-1004", ("shake_volume", "shake_pressure", "shake_both"), {"groom.strands": 200}
    ),
    "keys": Scene("volume/keys", "1001-1003", ("shown", "clumps", "between"), {"groom.strands": 600}),
    "locks": Scene("locks/patch", "1013-1026", ("half", "locked"), {}),
    "particles": Scene("particles/shake", "1001-1005", ("cloud", "even_cloud", "stiff_cloud", "hair"), {}),
    "particles as printed": Scene("particles/printed", "1001-1003", ("explicit_24", "attracted", "rubbed"), {}),
    "particles in wind": Scene("particles/wind", "1001-1003", ("cloud", "billboards"), {}),
}


def measure_digests(threads: Sequence[int], scenes: Sequence[str], echo: Echo) -> Report:
    """Compute scenes with these numbers of threads in empty caches; a row a value, a column a number of threads.

    Raises BadInput for an unknown scene, and where a node fails.
    """
    if unknown := set(scenes) - set(SCENES):
        raise BadInput(f"unknown scene {sorted(unknown)[0]!r}", where="--scene", right=", ".join(SCENES))
    rows: dict[tuple[str, str], Case] = {}
    for count in threads:
        with tempfile.TemporaryDirectory() as cache:
            for name in scenes or SCENES:
                echo(f"{name}, {count} threads")
                for value, digest in digests_of(SCENES[name], cache, count):
                    row = rows.setdefault((name, value), {"scene": name, "value": value})
                    row[f"threads {count}"] = digest
    return make_report(__name__, {"digests": list(rows.values())})


def digests_of(scene: Scene, cache: str, threads: int) -> Iterator[tuple[str, str]]:
    """Compute a scene, and digest its values at the last frame, or for the shot."""
    shot = hairpipe.load(GRAPHS / f"{scene.graph}.toml", cache=cache).changed(scene.changed)
    run = shot.run(scene.frames, to=scene.nodes, jobs=threads, publish_root=Path(cache))
    if not run.ok:
        raise BadInput(str(run), where=scene.graph)
    last = scene.frames.rpartition("-")[2]
    for node in scene.nodes:
        at = f"@{last}" if shot.nodes[node].per_frame else ""
        for output in shot.nodes[node].type.outputs:
            state = blake2b(digest_size=DIGEST_BYTES)
            name = f"{node}.{output}" if output else node
            for part in parts_of(shot.get(name + at, frames=scene.frames)):
                state.update(part)
            yield name, state.hexdigest()


def parts_of(value: Any) -> Iterator[bytes]:
    """List the bytes of a value in the order of its fields: those of files, arrays and plain values, no names."""
    if isinstance(value, Path):
        yield value.read_bytes()
    elif isinstance(value, np.ndarray):
        yield f"{value.dtype}{value.shape}".encode()
        yield np.ascontiguousarray(value).tobytes()
    elif dataclasses.is_dataclass(value):
        for field in dataclasses.fields(value):
            yield from parts_of(getattr(value, field.name))
    elif isinstance(value, dict):
        for name in value:
            yield from parts_of(value[name])
    elif isinstance(value, tuple):
        for item in value:
            yield from parts_of(item)
    else:
        yield repr(value).encode()
