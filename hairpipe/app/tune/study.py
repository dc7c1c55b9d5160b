"""Measure models of a scene's hair on a sample, as ordinary runs of the graph with other settings.

Merge variants of a graph into one graph: common nodes once, differing nodes under names of their own.
"""

import importlib
import math
from collections.abc import Iterable, Sequence
from copy import deepcopy
from dataclasses import dataclass, replace
from itertools import combinations
from typing import Any, Protocol

import numpy as np

from hairpipe.app.api.reports import Outcome
from hairpipe.app.api.shot import Shot
from hairpipe.app.tune.chaos import MODEL, REFERENCE, Chaos, chaos_of, climate_of, refusal
from hairpipe.app.tune.measured import Measured, Results, failed, measured_of, seconds_per_frame
from hairpipe.app.tune.quantity import Tolerance
from hairpipe.app.tune.sampling import STRANDS, Sample
from hairpipe.app.tune.simplifications import OUTPUT, above, levelsets_of, scaled_steps
from hairpipe.engine.file.overrides import Tables, drop, nodes_of, put
from hairpipe.engine.store.digest import digest
from hairpipe.errors import BadInput
from hairpipe.values import Table
from hairpipe.values.simplification import Simplification

MARK = 8
"""Characters of the digest that distinguishes variants of a node."""
KEYS = "-keys"
"""Suffix of the names of nodes of key strands: the thinned groom, and what depends on it."""
SAMPLE = "tune-sample"
"""Name of the node that samples strands."""
MEMBER = "tune-member"
"""Name of the node that makes a member of an ensemble."""
INTERPOLATED = ("body", "ends", "surface", "parts")
"""Sockets that a simulation and an interpolation have in common."""


def simplified(tables: Tables, hair: str, parts: Iterable[Simplification]) -> Tables:
    """Return the tables of a graph with simplifications of a simulation applied; pure."""
    tables = deepcopy(tables)
    every = 1
    others = []
    for part in parts:
        for target in part.drops:
            drop(tables, target)
        for target, value in part.puts:
            put(tables, target, value)
        every = max(every, part.keys)
        others = others + [part] * bool(part.instead)
    if others:
        return with_other_model(tables, hair, others[0])
    return tables if every == 1 else with_keys(tables, hair, every)


def with_keys(tables: Tables, hair: str, every: int) -> Tables:
    """Return the tables with one strand in `every` simulated, and the others interpolated where hair is used; pure."""
    keys = f"{hair}{KEYS}"
    groom = tables[hair]["in"]["groom"]
    interpolated = {socket: edge for socket, edge in tables[hair]["in"].items() if socket in INTERPOLATED}
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
    tables[f"{source}{KEYS}"] = {key: value for key, value in table.items() if key != "publish"} | {"in": changed}
    return f"{source}{KEYS}{dot}{output}"


def with_other_model(tables: Tables, hair: str, part: Simplification) -> Tables:
    """Return the tables with other nodes in place of a simulation, see `Simplification.instead`; pure."""
    module, _, function = part.instead.partition(":")
    groom = tables[hair]["in"]["groom"]
    whole = tables[SAMPLE]["in"]["groom"] if groom == SAMPLE else groom
    nodes = getattr(importlib.import_module(module), function)(hair, tables[hair], whole, part)
    return with_node(tables, hair, nodes[hair], instead=f"{hair}.{OUTPUT}") | {
        name: table for name, table in nodes.items() if name != hair
    }


def sampled(tables: Tables, hair: str, sample: Sample) -> Tables:
    """Return the tables of a graph with its hair simulated for a sample only; pure."""
    groom = tables[hair]["in"]["groom"]
    settings = {"strands": sample.strands, "patches": sample.patches, "number": sample.number}
    table = {"type": "sample_groom", "in": {"groom": groom}, **settings}
    return with_node(tables, SAMPLE, table, instead=groom) | {"frames": [sample.begin, sample.last]}


def shown_of(hair: str) -> str:
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
    """Return one graph that holds nodes of every variant with their dependencies, and their names there by variant.

    A variant may lack some of the nodes. Nothing is published. A node keeps its name, followed by a digest of all that
    determines it.
    """
    merged: Tables = {}
    names = {
        label: [gather(merged, tables, node, {}) for node in nodes if node in tables]
        for label, tables in variants.items()
    }
    first = next(iter(variants.values()))
    return {key: value for key, value in first.items() if not isinstance(value, dict)} | merged, names


def gather(merged: Tables, tables: Tables, node: str, known: dict[str, str]) -> str:
    """Add a node and its dependencies to merged tables, in place, and return its name there."""
    if node not in known:
        table = {key: value for key, value in tables[node].items() if key != "publish"}

        def renamed(edge: str) -> str:
            source, dot, output = edge.partition(".")
            return gather(merged, tables, source, known) + dot + output

        if "in" in table:
            table["in"] = map_edges(table["in"], renamed)
        known[node] = f"{node}-{digest('node', plain(table))[:MARK]}"
        merged[known[node]] = table
    return known[node]


def map_edges(edges: Tables, change: Any) -> Tables:
    return {
        socket: [change(edge) for edge in value] if isinstance(value, list) else change(value)
        for socket, value in edges.items()
    }


def plain(value: Any) -> Any:
    if isinstance(value, dict):
        return {key: plain(item) for key, item in value.items()}
    if isinstance(value, list):
        return [plain(item) for item in value]
    return value if isinstance(value, bool | int | float | str) else str(value)


ERROR, CLIMATE = "tune-error", "tune-climate"
"""Names of the comparing nodes."""
AS_IT_IS = "the graph as it is"
FINE, FINEST = 0.5, 0.25
"""Factors on the steps of the graph of the two models that test the convergence of the reference."""
Parts = frozenset[Simplification]
Run = tuple[Parts, int]
"""A model, and the number of the member of its hair."""


class Interrupted(Exception):
    """A run was interrupted; its results are kept."""


class RunNodes(Protocol):
    """Runs a shot up to some nodes at some frames."""

    def __call__(
        self, text: str, shot: Shot, nodes: Sequence[str], frames: Sequence[int], *, timed: bool = True
    ) -> Outcome:
        """Run a shot.

        text   describes what is measured
        timed  whether processor times are compared: on one thread of this machine, one simulation at a time; otherwise
               simulations run side by side, and the others go on after a failure
        """
        ...


@dataclass(frozen=True)
class Request:
    """Input of tuning.

    hair     node of the simulation
    run      runs nodes of a shot
    budget   processor time of a frame, to report its smallest error [s]; None without one
    check    whether the choice is also measured on other strands and frames
    strands  number of strands of the sample
    time     processor time after which no other model is measured [s]; None: a tenth of that of the shot's own
             simulation, ten minutes at least
    looks    for chaotic hair: largest difference in an observable, over that within the reference; None: any
    """

    shot: Shot
    hair: str
    tolerance: Tolerance
    run: RunNodes
    budget: float | None = None
    check: bool = False
    strands: int = STRANDS
    time: float | None = None
    looks: float | None = None


@dataclass(frozen=True)
class Comparison:
    """Some runs of one graph, and the tables of all pairs of them.

    names   nodes of each run: those that simulate, interpolate or deform hair
    """

    shot: Shot
    names: list[list[str]]

    @property
    def inputs(self) -> list[str]:
        return [edge.node for nodes in self.names for edge in self.shot.nodes[nodes[0]].edges.values()]

    def pairs(self, results: Results) -> dict[tuple[int, int], Table]:
        return {pair: results.value(error_of(pair)) for pair in combinations(range(len(self.names)), 2)}


class Study:
    """A scene, a sample of it, and the measurements on the sample.

    Where hair may be chaotic, the reference is several members at half the steps, else one run at a quarter of them.

    Simulations run side by side, but for those whose times are compared: a model, without other members, in the
    measured frames. These run one at a time, after all others, so that side by side or not, times are those of one.

    scale   strands of the scene over those of the sample
    tip     initial difference of members of an ensemble [m]; None where hair is not chaotic
    chaos   chaos of the reference, once it was measured
    limit   processor time after which no other model is to be measured [s], and whether it was reached
    """

    def __init__(self, request: Request, sample: Sample, total: int, tip: float | None = None) -> None:
        self.request, self.shot, self.hair = request, request.shot, request.hair
        self.sample, self.tip = sample, tip
        self.scale = total / sample.strands
        self.chaos: Chaos | None = None
        self.limit, self.stopped = math.inf, False
        self._node = self.shot.graph.node(self.hair)
        self._reference = self.refined(FINEST if tip is None else FINE)
        self._faults: dict[str, str] = {}
        self._processor: dict[str, float] = {}
        self._known: dict[Parts, Measured] = {}
        self._confirmed: dict[Parts, Measured] = {}

    @property
    def steps(self) -> str:
        """The steps of the reference, in words."""
        return text_of(self._reference)

    def has_time(self) -> bool:
        """Whether the results that were compared, also those that were in the store, took less time than the limit."""
        self.stopped = self.stopped or sum(self._processor.values()) >= self.limit
        return not self.stopped

    def refined(self, factor: float) -> Parts:
        """Describe the scene's own model at finer steps; a model without steps is unchanged."""
        puts = tuple((target, max(value, 2e-5)) for target, value in scaled_steps(self._node, factor))
        if not puts:
            return frozenset()
        return frozenset([Simplification("steps", 0, f"steps up to 1/{1.0 / puts[0][1]:.0f} s", puts)])

    def converged(self) -> Measured | Chaos:
        """Measure the change of the reference when its steps are halved, or its chaos."""
        fine = self.refined(FINE)
        runs = [(self._reference, 0), (fine, 0)] if self.tip is None else [(self._reference, m) for m in REFERENCE]
        self._compute_ahead(f"reference: {self.steps}", [run for run in runs if run != (frozenset(), 0)])
        if self.tip is None:
            return self.measure(fine)
        compared = self._comparison(runs)
        fault = self._compute(f"reference: {self.steps}", compared, runs)
        if fault:
            return failed(fault)
        pairs = compared.pairs(self._results(compared))
        self.chaos = chaos_of(pairs, self.request.tolerance, self.tip, self._frames, self.shot.fps)
        return self.chaos

    def measure(self, parts: Iterable[Simplification]) -> Measured:
        """Measure the scene's model with these simplifications, once; of chaotic hair in predictable frames only."""
        return self.measure_all([parts])[0]

    def measure_all(self, models: Iterable[Iterable[Simplification]]) -> list[Measured]:
        """Measure several models, which are simulated side by side before the measured frames."""
        wanted = [*map(frozenset, models)]
        new = [parts for parts in dict.fromkeys(wanted) if parts not in self._known]
        if len(new) > 1:
            runs = [(parts, 0) for parts in new if self._is_valid(parts)]
            self._compute_ahead(f"{len(new)} models up to frame {self.sample.first - 1}", runs, settling=True)
        for parts in new:
            self._known[parts] = self._measure(parts)
        return [self._known[parts] for parts in wanted]

    def confirm(self, parts: Iterable[Simplification]) -> Measured:
        """Measure the same, once, and if hair is chaotic also its climate."""
        return self.confirm_all([parts])[0]

    def confirm_all(self, models: Iterable[Iterable[Simplification]]) -> list[Measured]:
        """Confirm several models, whose members are simulated side by side."""
        wanted = [*map(frozenset, models)]
        screened = [parts for parts, found in zip(wanted, self.measure_all(wanted), strict=True) if found.screened]
        runs = [(parts, member) for parts in screened if parts not in self._confirmed for member in MODEL[1:]]
        self._compute_ahead(f"{len(runs)} members of models", runs)
        for parts in wanted:
            if parts not in self._confirmed:
                self._confirmed[parts] = self._confirm(parts)
        return [self._confirmed[parts] for parts in wanted]

    @property
    def _frames(self) -> range:
        """Frames at which runs are compared: with members, from the start of the simulation."""
        return self.sample.frames if self.tip is None else self.sample.simulated

    @property
    def _measured(self) -> range:
        """Frames of the errors: the last predictable ones, as many as the sample has."""
        if self.chaos is None:
            return self.sample.frames
        return self._frames[1 : 1 + max(self.chaos.predicted, 1)][-len(self.sample.frames) :]

    def _measure(self, parts: Parts) -> Measured:
        runs = [(parts, 0), (self._reference, 0)]
        try:
            compared = self._comparison(runs)
        except BadInput as refused:  # settings that exclude each other
            return failed(str(refused))
        fault = self._compute(text_of(parts), compared, runs)
        if fault:
            return failed(fault)
        results = self._results(compared)
        seconds = self._seconds(compared.shot, compared.names[0], results)
        found = measured_of(results.value(error_of((0, 1))), self.request.tolerance, seconds, self._measured)
        return replace(found, screened=self.chaos is not None and self.chaos.chaotic and not found.fault)

    def _confirm(self, parts: Parts) -> Measured:
        found = self.measure(parts)
        chaos = self.chaos
        if not found.screened or chaos is None:
            return found
        runs = [(parts, member) for member in MODEL] + [(self._reference, member) for member in REFERENCE]
        compared = self._comparison(runs, predicted=max(chaos.predicted, 1))
        fault = self._compute(text_of(parts), compared, runs, [CLIMATE])
        if fault:
            return failed(fault)
        results = self._results(compared)
        tolerance = self.request.tolerance
        pairs = compared.pairs(results)
        if any(np.any(table["lost"]) for table in pairs.values()):
            return failed("hair of a member is not finite")
        climate = climate_of(pairs, results.value(CLIMATE), tolerance, chaos)
        refused = refusal(climate, chaos, tolerance, self.request.looks)
        error, bound = max(found.error, climate.bias), max(found.bound, climate.bound)
        return replace(found, error=error, bound=bound, screened=False, climate=climate, refused=refused)

    def _comparison(self, runs: Sequence[Run], predicted: int = 0) -> Comparison:
        """Lay out runs of models and members in one graph, and nodes that compare all pairs.

        predicted  frames after which climates are compared; 0: no comparison
        """
        merged, names = self._lay_out(runs)
        hair = [nodes[-1] for nodes in names]
        for one, other in combinations(range(len(runs)), 2):
            edges = {"hair": hair[one], "reference": hair[other]}
            table = {"type": "measure_patches", "in": edges, "patches": self.sample.patches}
            merged = with_node(merged, error_of((one, other)), table)
        if predicted:
            edges = {"hair": hair[: len(MODEL)], "truth": hair[len(MODEL) :]}
            table = {"type": "measure_climate", "in": edges, "predicted": predicted, "patches": self.sample.patches}
            table |= {"members": list(MODEL), "truth_members": list(REFERENCE)}
            merged = with_node(merged, CLIMATE, table)
        return Comparison(self.shot.edited(merged), names)

    def _lay_out(self, runs: Sequence[Run]) -> tuple[Tables, list[list[str]]]:
        """Lay out runs in one graph: its tables, and the nodes of each run; BadInput where settings exclude others."""
        tables = {
            str(place): simplified(self._tables_of(member), self.hair, parts)
            for place, (parts, member) in enumerate(runs)
        }
        last = [self.hair, shown_of(self.hair)]
        known = {*self.shot.tables, SAMPLE, MEMBER}
        others = [name for one in tables.values() for name in one if name not in known and not name.endswith(KEYS)]
        merged, found = merged_variants(tables, [*(name for name in dict.fromkeys(others) if name not in last), *last])
        whole = self.shot.edited(merged).nodes
        return merged, [[name for name in found[label] if whole[name].per_frame] for label in tables]

    def _tables_of(self, member: int) -> Tables:
        tables = self.shot.tables
        groom = tables[self.hair]["in"]["groom"]
        if member:
            table = {"type": "perturb_groom", "in": {"groom": groom}, "member": member, "tip": self.tip}
            tables = with_node(tables, MEMBER, table, instead=groom)
        return sampled(tables, self.hair, self.sample)

    def _compute(self, text: str, compared: Comparison, runs: Sequence[Run], more: Sequence[str] = ()) -> str:
        """Run the inputs, the reference and the others, and compare them; returns the fault."""
        shot, names = compared.shot, compared.names
        behind = (node.name for nodes in names for name in nodes for node in above(shot.graph, name))
        fault = next((self._faults[name] for name in behind if name in self._faults), "")
        reference = [
            name for nodes, (parts, _) in zip(names, runs, strict=True) if parts == self._reference for name in nodes
        ]
        errors = [error_of(pair) for pair in combinations(range(len(runs)), 2)]
        fault = fault or self._run_nodes(text, shot, compared.inputs, self.sample.simulated)
        fault = fault or self._run_nodes(f"reference: {self.steps}", shot, reference, self._frames)
        return fault or self._run_nodes(text, shot, [*errors, *more], self._frames)

    def _compute_ahead(self, text: str, runs: Sequence[Run], *, settling: bool = False) -> None:
        """Compute runs side by side, and note their faults.

        settling  only what simulates, before the measured frames
        """
        if not runs:
            return
        merged, names = self._lay_out(runs)
        compared = Comparison(self.shot.edited(merged), names)
        self._run_nodes(f"inputs of {text}", compared.shot, compared.inputs, self.sample.simulated)
        found = [compared.shot.nodes[name] for nodes in names for name in nodes]
        wanted = [node.name for node in found if node.type.mode == "scan" or not settling]
        frames = [self.sample.first - 1] if settling else self._frames
        self._run_nodes(text, compared.shot, wanted, frames, timed=False)

    def _is_valid(self, parts: Parts) -> bool:
        try:
            self._lay_out([(parts, 0)])
        except BadInput:
            return False
        return True

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

    def _results(self, compared: Comparison) -> Results:
        """Read the results of a comparison, and count their processor time."""
        results = Results(compared.shot, self._frames)
        self._processor |= results.processor
        return results

    def _seconds(self, shot: Shot, names: Sequence[str], results: Results) -> float:
        """Read the times of the nodes of hair, scaled to all strands where they depend on the sample."""
        frames = [frame for frame in self.sample.frames if frame > self.sample.begin]
        others = [results.seconds(name, frames) for name in levelsets_of(shot.nodes[names[0]])]
        whole = [name for name in names if not any(node.name.startswith(SAMPLE) for node in above(shot.graph, name))]
        hair = [results.seconds(name, frames) for name in names if name not in whole]
        others += [results.seconds(name, frames) for name in whole]
        return seconds_per_frame(hair, others, len(frames), self.scale)


def text_of(parts: Iterable[Simplification]) -> str:
    return ", ".join(part.text for part in sorted(parts, key=lambda part: part.axis)) or AS_IT_IS


def error_of(pair: tuple[int, int]) -> str:
    return f"{ERROR}-{pair[0]}-{pair[1]}"
