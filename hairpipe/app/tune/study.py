"""Measure models of a scene's hair on a sample, as ordinary runs of the graph with other settings."""

import importlib
import json
import math
from collections.abc import Callable, Iterable, Sequence
from copy import deepcopy
from dataclasses import dataclass, replace
from itertools import combinations
from typing import NamedTuple, Protocol

import numpy as np

from hairpipe.app.api.reports import Outcome
from hairpipe.app.api.shot import Shot
from hairpipe.app.tune.measured import (
    MODEL,
    REFERENCE,
    Chaos,
    Measured,
    Results,
    Tolerance,
    chaos_of,
    climate_of,
    failed,
    measured_of,
    refusal,
    seconds_per_frame,
)
from hairpipe.app.tune.sampling import STRANDS, Sample
from hairpipe.app.tune.simplifications import OUTPUT, above, levelsets_of, scaled_steps
from hairpipe.engine.file.overrides import Tables, drop, nodes_of, put
from hairpipe.engine.store.digest import digest
from hairpipe.errors import BadInput
from hairpipe.values.simplification import Simplification

MARK = 8  # characters of the digest that distinguishes variants of a node
KEYS = "-keys"  # suffix of the names of nodes of key strands: the thinned groom, and what depends on it
SAMPLE, MEMBER, ERROR, CLIMATE = "tune-sample", "tune-member", "tune-error", "tune-climate"
"""Names of the nodes that sample strands, make a member of an ensemble, and compare runs."""
INTERPOLATED = ("body", "ends", "surface", "parts")  # sockets that a simulation and an interpolation have in common
AS_IT_IS = "the graph as it is"
FINE, FINEST = 0.5, 0.25
"""Factors on the steps of the graph of the two models that test the convergence of the reference."""
SMALLEST_STEP = 2e-5
Parts = frozenset[Simplification]
Run = tuple[Parts, int]  # a model, and the number of the member of its hair


def simplified(tables: Tables, hair: str, parts: Iterable[Simplification]) -> Tables:
    """Return the tables of a graph with simplifications of a simulation applied; pure."""
    tables = deepcopy(tables)
    parts = list(parts)
    for part in parts:
        for target in part.drops:
            drop(tables, target)
        for target, value in part.puts:
            put(tables, target, value)
    for part in parts:
        if part.instead:
            return with_other_model(tables, hair, part)
    every = max((part.keys for part in parts), default=1)
    return tables if every == 1 else with_keys(tables, hair, every)


def with_keys(tables: Tables, hair: str, every: int) -> Tables:
    """Return the tables with one strand in `every` simulated, and the others interpolated where hair is used; pure."""
    keys = f"{hair}{KEYS}"
    edges = tables[hair]["in"]
    groom = edges["groom"]
    interpolated = {socket: edge for socket, edge in edges.items() if socket in INTERPOLATED}
    table = {"type": "interpolate_hair", "in": {"hair": hair, "keys": keys, "groom": groom} | interpolated}
    for edge in (hair, f"{hair}.{OUTPUT}"):
        tables = with_node(tables, shown_of(hair), table, instead=edge)
    tables[hair]["in"] = map_edges(tables[hair]["in"], lambda edge: of_keys(tables, edge, groom, keys))
    return tables | {keys: {"type": "thin_groom", "in": {"groom": groom}, "every": every}}


def of_keys(tables: Tables, edge: str, groom: str, keys: str) -> str:
    """Return the edge of key strands in place of one of all strands: nodes between are repeated, in place."""
    if edge == groom:
        return keys
    source, dot, output = edge.partition(".")
    table = tables[source]
    edges = table.get("in", {})
    changed = map_edges(edges, lambda other: of_keys(tables, other, groom, keys))
    if changed == edges:
        return edge
    tables[f"{source}{KEYS}"] = unpublished(table) | {"in": changed}
    return f"{source}{KEYS}{dot}{output}"


def with_other_model(tables: Tables, hair: str, part: Simplification) -> Tables:
    """Return the tables with other nodes in place of a simulation, see `Simplification.instead`; pure."""
    module, _, function = part.instead.partition(":")
    groom = tables[hair]["in"]["groom"]
    whole = tables[SAMPLE]["in"]["groom"] if groom == SAMPLE else groom
    nodes = getattr(importlib.import_module(module), function)(hair, tables[hair], whole, part)
    return with_node(tables, hair, nodes.pop(hair), instead=f"{hair}.{OUTPUT}") | nodes


def sampled(tables: Tables, hair: str, sample: Sample) -> Tables:
    """Return the tables of a graph with its hair simulated for a sample only; pure."""
    groom = tables[hair]["in"]["groom"]
    settings = {"strands": sample.strands, "patches": sample.patches, "number": sample.number}
    table = {"type": "sample_groom", "in": {"groom": groom}, **settings}
    return with_node(tables, SAMPLE, table, instead=groom) | {"frames": [sample.begin, sample.last]}


def shown_of(hair: str) -> str:
    """Name the node that interpolates between keys."""
    return f"{hair}-shown"


def with_node(tables: Tables, name: str, table: Tables, instead: str | None = None) -> Tables:
    """Return the tables with another node; pure.

    instead  edge whose consumers take the new node's value from now on
    """
    tables = deepcopy(tables)
    for other in nodes_of(tables).values() if instead is not None else ():
        if "in" in other:
            other["in"] = map_edges(other["in"], lambda edge: name if edge == instead else edge)
    return tables | {name: table}


def merged_variants(variants: dict[str, Tables], nodes: Iterable[str]) -> tuple[Tables, dict[str, list[str]]]:
    """Merge variants into one graph: nodes with their dependencies, common ones once, and their names by variant."""
    merged: Tables = {}
    names = {
        label: [gather(merged, tables, node, {}) for node in nodes if node in tables]
        for label, tables in variants.items()
    }
    first = next(iter(variants.values()))
    return {key: value for key, value in first.items() if not isinstance(value, dict)} | merged, names


def gather(merged: Tables, tables: Tables, node: str, known: dict[str, str]) -> str:
    """Add a node and its dependencies to merged tables, in place; its name there has a digest of what determines it."""
    if node not in known:
        table = unpublished(tables[node])

        def renamed(edge: str) -> str:
            source, dot, output = edge.partition(".")
            return gather(merged, tables, source, known) + dot + output

        if "in" in table:
            table["in"] = map_edges(table["in"], renamed)
        known[node] = f"{node}-{digest('node', json.dumps(table, sort_keys=True, default=str))[:MARK]}"
        merged[known[node]] = table
    return known[node]


def unpublished(table: Tables) -> Tables:
    return {key: value for key, value in table.items() if key != "publish"}


def map_edges(edges: Tables, change: Callable[[str], str]) -> Tables:
    return {
        socket: [change(edge) for edge in value] if isinstance(value, list) else change(value)
        for socket, value in edges.items()
    }


class Interrupted(Exception):
    """A run was interrupted; its results are kept."""


class RunNodes(Protocol):
    """Runs a shot up to some nodes at some frames; the text describes what is measured.

    timed  whether processor times are compared: on one thread of this machine, one simulation at a time; otherwise
           simulations run side by side, and the others go on after a failure
    """

    def __call__(
        self, text: str, shot: Shot, nodes: Sequence[str], frames: Sequence[int], *, timed: bool = True
    ) -> Outcome: ...


@dataclass(frozen=True)
class Request:
    """Input of tuning.

    time   processor time after which no other model is measured [s]; None: a tenth of that of the shot's own
           simulation, ten minutes at least
    looks  for chaotic hair: largest difference in an observable, over that within the reference; None: any
    """

    shot: Shot
    hair: str  # node of the simulation
    tolerance: Tolerance
    run: RunNodes  # runs nodes of a shot
    budget: float | None = None  # processor time of a frame, to report its smallest error [s]; None without one
    check: bool = False  # whether the choice is also measured on other strands and frames
    strands: int = STRANDS  # number of strands of the sample
    time: float | None = None
    looks: float | None = None


class Comparison(NamedTuple):
    """Runs of models and members in one graph, with nodes that compare all pairs of them."""

    shot: Shot
    runs: Sequence[Run]
    names: list[list[str]]  # nodes of each run: those that simulate, interpolate or deform hair

    @property
    def inputs(self) -> list[str]:
        return [edge.node for nodes in self.names for edge in self.shot.nodes[nodes[0]].edges.values()]

    @property
    def errors(self) -> dict[tuple[int, int], str]:
        """Nodes that compare two runs, by their places."""
        return {(one, other): f"{ERROR}-{one}-{other}" for one, other in combinations(range(len(self.runs)), 2)}


class Study:
    """A scene, a sample of it, and the measurements on the sample.

    Where hair may be chaotic, the reference is several members at half the steps, else one run at a quarter of them.

    Simulations run side by side, but for those whose times are compared: a model, without other members, in the
    measured frames. These run one at a time, after all others, so that side by side or not, times are those of one.

    scale   strands of the scene over those of the sample
    tip     initial difference of members of an ensemble [m]; None where hair is not chaotic
    steps   those of the reference, in words
    chaos   chaos of the reference, once it was measured
    limit   processor time after which no other model is to be measured [s]
    stopped whether it was reached
    """

    def __init__(self, request: Request, sample: Sample, total: int, tip: float | None = None) -> None:
        self.request, self.shot, self.hair = request, request.shot, request.hair
        self.sample, self.tip = sample, tip
        self.scale = total / sample.strands
        self.chaos: Chaos | None = None
        self.limit, self.stopped = math.inf, False
        self._reference = self.refined(FINEST if tip is None else FINE)
        self.steps = text_of(self._reference)
        self._faults: dict[str, str] = {}
        self._processor: dict[str, float] = {}
        self._measured: dict[Parts, Measured] = {}
        self._confirmed: dict[Parts, Measured] = {}

    def has_time(self) -> bool:
        """Whether the results that were compared, also those that were in the store, took less time than the limit."""
        self.stopped = self.stopped or sum(self._processor.values()) >= self.limit
        return not self.stopped

    def refined(self, factor: float) -> Parts:
        """Describe the scene's own model at finer steps; a model without steps is unchanged."""
        scaled = scaled_steps(self.shot.graph.node(self.hair), factor)
        puts = tuple((target, max(value, SMALLEST_STEP)) for target, value in scaled)
        if not puts:
            return frozenset()
        return frozenset([Simplification("steps", 0, f"steps up to 1/{1.0 / puts[0][1]:.0f} s", puts)])

    def converged(self) -> Measured | Chaos:
        """Measure the change of the reference when its steps are halved, or its chaos."""
        fine = self.refined(FINE)
        text = f"reference: {self.steps}"
        runs = [(self._reference, 0), (fine, 0)] if self.tip is None else [(self._reference, m) for m in REFERENCE]
        self._compute_ahead(text, [run for run in runs if run != (frozenset(), 0)])
        if self.tip is None:
            return self.measure_all([fine])[0]
        compared = self._comparison(runs)
        results, fault = self._compute(text, compared)
        if fault:
            return failed(fault)
        pairs = {pair: results.value(name) for pair, name in compared.errors.items()}
        self.chaos = chaos_of(pairs, self.request.tolerance, self.tip, self._frames, self.shot.fps)
        return self.chaos

    def measure_all(self, models: Iterable[Iterable[Simplification]]) -> list[Measured]:
        """Measure models, each once, side by side before the measured frames; chaotic hair in predictable frames only.

        A model is the scene's own with some simplifications.
        """
        wanted = [*map(frozenset, models)]
        compared: dict[Parts, Comparison] = {}
        for parts in dict.fromkeys(wanted):
            try:
                if parts not in self._measured:
                    compared[parts] = self._comparison([(parts, 0), (self._reference, 0)])
            except BadInput as refused:  # settings that exclude each other
                self._measured[parts] = failed(str(refused))
        if len(compared) > 1:
            text = f"{len(compared)} models up to frame {self.sample.first - 1}"
            self._compute_ahead(text, [(parts, 0) for parts in compared], settling=True)
        self._measured |= {parts: self._measure(parts, pair) for parts, pair in compared.items()}
        return [self._measured[parts] for parts in wanted]

    def confirm(self, parts: Iterable[Simplification]) -> Measured:
        """Measure the same, once, and if hair is chaotic also its climate."""
        return self.confirm_all([parts])[0]

    def confirm_all(self, models: Iterable[Iterable[Simplification]]) -> list[Measured]:
        """Confirm several models, whose members are simulated side by side."""
        wanted = [*map(frozenset, models)]
        found = dict(zip(wanted, self.measure_all(wanted), strict=True))
        new = [parts for parts in found if parts not in self._confirmed]
        runs = [(parts, member) for parts in new if found[parts].screened for member in MODEL[1:]]
        self._compute_ahead(f"{len(runs)} members of models", runs)
        self._confirmed |= {parts: self._confirm(parts, found[parts]) for parts in new}
        return [self._confirmed[parts] for parts in wanted]

    @property
    def _frames(self) -> range:
        """Frames at which runs are compared: with members, from the start of the simulation."""
        return self.sample.frames if self.tip is None else self.sample.simulated

    def _measure(self, parts: Parts, compared: Comparison) -> Measured:
        results, fault = self._compute(text_of(parts), compared)
        if fault:
            return failed(fault)
        frames = self.sample.frames
        if self.chaos is not None:  # the last predictable ones, as many as the sample has
            frames = self._frames[1 : 1 + max(self.chaos.predicted, 1)][-len(frames) :]
        seconds = self._seconds(compared.shot, compared.names[0], results)
        found = measured_of(results.value(compared.errors[0, 1]), self.request.tolerance, seconds, frames)
        return replace(found, screened=self.chaos is not None and self.chaos.chaotic and not found.fault)

    def _confirm(self, parts: Parts, found: Measured) -> Measured:
        chaos = self.chaos
        tolerance = self.request.tolerance
        if not found.screened or chaos is None:
            return found
        runs = [(parts, member) for member in MODEL] + [(self._reference, member) for member in REFERENCE]
        compared = self._comparison(runs, predicted=max(chaos.predicted, 1))
        results, fault = self._compute(text_of(parts), compared)
        if fault:
            return failed(fault)
        pairs = {pair: results.value(name) for pair, name in compared.errors.items()}
        if any(np.any(table["lost"]) for table in pairs.values()):
            return failed("hair of a member is not finite")
        climate = climate_of(pairs, results.value(CLIMATE), tolerance, chaos)
        refused = refusal(climate, chaos, tolerance, self.request.looks)
        error, bound = max(found.error, climate.bias), max(found.bound, climate.bound)
        return replace(found, error=error, bound=bound, screened=False, climate=climate, refused=refused)

    def _comparison(self, runs: Sequence[Run], predicted: int = 0) -> Comparison:
        """Lay out runs in one graph, and nodes that compare them."""
        merged, names = self._lay_out(runs)
        hair = [nodes[-1] for nodes in names]
        compared = Comparison(self.shot, runs, names)
        for (one, other), name in compared.errors.items():
            edges = {"hair": hair[one], "reference": hair[other]}
            merged[name] = {"type": "measure_patches", "in": edges, "patches": self.sample.patches}
        if predicted:
            edges = {"hair": hair[: len(MODEL)], "truth": hair[len(MODEL) :]}
            table = {"type": "measure_climate", "in": edges, "predicted": predicted, "patches": self.sample.patches}
            merged[CLIMATE] = table | {"members": list(MODEL), "truth_members": list(REFERENCE)}
        return compared._replace(shot=self.shot.edited(merged))

    def _lay_out(self, runs: Sequence[Run]) -> tuple[Tables, list[list[str]]]:
        """Lay out runs in one graph: its tables, and the nodes of each run; BadInput where settings exclude others."""
        tables = {
            str(place): simplified(self._tables_of(member), self.hair, parts)
            for place, (parts, member) in enumerate(runs)
        }
        last = [self.hair, shown_of(self.hair)]
        known = {*self.shot.tables, SAMPLE, MEMBER, *last}
        others = {name: None for one in tables.values() for name in one if name not in known}
        merged, found = merged_variants(tables, [*(name for name in others if not name.endswith(KEYS)), *last])
        whole = self.shot.edited(merged).nodes
        return merged, [[name for name in found[label] if whole[name].per_frame] for label in tables]

    def _tables_of(self, member: int) -> Tables:
        tables = self.shot.tables
        groom = tables[self.hair]["in"]["groom"]
        if member:
            table = {"type": "perturb_groom", "in": {"groom": groom}, "member": member, "tip": self.tip}
            tables = with_node(tables, MEMBER, table, instead=groom)
        return sampled(tables, self.hair, self.sample)

    def _compute(self, text: str, compared: Comparison) -> tuple[Results, str]:
        """Run the inputs, the reference and the others, and compare them; return the results, and a fault."""
        shot, names = compared.shot, compared.names
        behind = (node.name for nodes in names for name in nodes for node in above(shot.graph, name))
        fault = next((self._faults[name] for name in behind if name in self._faults), "")
        pairs = zip(names, compared.runs, strict=True)
        reference = [name for nodes, (parts, _) in pairs if parts == self._reference for name in nodes]
        fault = fault or self._run_nodes(text, shot, compared.inputs, self.sample.simulated)
        fault = fault or self._run_nodes(f"reference: {self.steps}", shot, reference, self._frames)
        comparing = [name for name in (*compared.errors.values(), CLIMATE) if name in shot.nodes]
        fault = fault or self._run_nodes(text, shot, comparing, self._frames)
        results = Results(shot, self._frames)
        if not fault:
            self._processor |= results.processor
        return results, fault

    def _compute_ahead(self, text: str, runs: Sequence[Run], *, settling: bool = False) -> None:
        """Compute runs side by side, and note their faults."""
        if not runs:
            return
        merged, names = self._lay_out(runs)
        ahead = Comparison(self.shot.edited(merged), runs, names)
        self._run_nodes(f"inputs of {text}", ahead.shot, ahead.inputs, self.sample.simulated)
        nodes = [ahead.shot.nodes[name] for group in names for name in group]
        wanted = [node.name for node in nodes if node.type.mode == "scan" or not settling]
        frames = [self.sample.first - 1] if settling else self._frames
        self._run_nodes(text, ahead.shot, wanted, frames, timed=False)

    def _run_nodes(
        self, text: str, shot: Shot, nodes: Sequence[str], frames: Sequence[int], *, timed: bool = True
    ) -> str:
        """Run a shot up to some nodes, and note the faults of nodes; returns the first."""
        outcome = self.request.run(text, shot, nodes, frames, timed=timed)
        if outcome.interrupted:
            raise Interrupted
        for failure in outcome.failures:
            if failure.kind not in ("input", "node", "diverged"):  # these alone are a property of a model
                raise BadInput(f"{text}: {failure}", where=self.shot.path)
            self._faults[failure.task.node] = str(failure.message)
        return next((str(failure.message) for failure in outcome.failures), "")

    def _seconds(self, shot: Shot, names: Sequence[str], results: Results) -> float:
        """Read the times of the nodes of hair, scaled to all strands where they depend on the sample."""
        frames = [frame for frame in self.sample.frames if frame > self.sample.begin]
        whole = [name for name in names if not any(node.name.startswith(SAMPLE) for node in above(shot.graph, name))]
        others = [results.seconds(name, frames) for name in (*levelsets_of(shot.nodes[names[0]]), *whole)]
        hair = [results.seconds(name, frames) for name in names if name not in whole]
        return seconds_per_frame(hair, others, len(frames), self.scale)


def text_of(parts: Iterable[Simplification]) -> str:
    return ", ".join(part.text for part in sorted(parts, key=lambda part: part.axis)) or AS_IT_IS
