"""Measures models of a scene's hair on a sample, as ordinary runs of the graph with other settings."""

from collections.abc import Callable, Iterable, Sequence

from hairpipe.api.reports import Outcome
from hairpipe.api.shot import Shot
from hairpipe.errors import BadInput
from hairpipe.graph.file.overrides import Tables
from hairpipe.tune.measured import Measured, failed, measured_of, seconds_per_frame
from hairpipe.tune.quantity import Tolerance
from hairpipe.tune.results import Results
from hairpipe.tune.sampling import Sample
from hairpipe.tune.simplifications import BODIES, Simplification, scaled_steps
from hairpipe.tune.variants import SAMPLE, cloud_of, merged_variants, shown_of, simplified, with_node

CarryOut = Callable[[str, Shot, Sequence[str], Sequence[int]], Outcome]
"""Runs a shot up to some nodes at some frames; the text describes what is measured."""
ERROR = "tune-error"
"""Name of the node that compares."""
FINE, FINEST = 0.5, 0.25
"""Factors on the steps of the graph, of the two models that show whether the reference is converged."""


class Interrupted(Exception):
    """A run was interrupted; what was computed is kept."""


class Study:
    """A scene, a sample of it, and what has been measured there.

    scale  strands of the scene over those of the sample
    """

    def __init__(self, shot: Shot, hair: str, sample: Sample, total: int, tolerance: Tolerance, run: CarryOut) -> None:
        self.shot, self.hair, self.sample = shot, hair, sample
        self.scale = total / sample.strands
        self.tolerance = tolerance
        self._run = run
        self._tables = sampled(shot.tables, hair, sample)
        self._node = shot.graph.node(hair)
        self._known: dict[frozenset[Simplification], Measured] = {}

    def refined(self, factor: float) -> Simplification:
        """Describe the scene's own model at finer steps."""
        puts = tuple((target, max(value, 2e-5)) for target, value in scaled_steps(self._node, factor))
        return Simplification("steps", 0, f"steps up to 1/{1.0 / puts[0][1]:.0f} s", puts)

    def converged(self) -> Measured:
        """Measure how far the reference moves when its steps are halved."""
        found = self.measure([self.refined(FINE)])
        if found.fault:
            raise BadInput(f"the graph itself does not get through the sample: {found.fault}", where=self.shot.path)
        return found

    def measure(self, parts: Iterable[Simplification]) -> Measured:
        """Measure the scene's model with these simplifications; once."""
        parts = frozenset(parts)
        if parts not in self._known:
            self._known[parts] = self._measure(parts)
        return self._known[parts]

    def _measure(self, parts: frozenset[Simplification]) -> Measured:
        text = ", ".join(part.text for part in sorted(parts, key=lambda part: part.axis)) or "the graph as it is"
        finest = self.refined(FINEST)
        variants = {"reference": [finest], "variant": parts}
        tables = {label: simplified(self._tables, self.hair, changes) for label, changes in variants.items()}
        merged, names = merged_variants(tables, [cloud_of(self.hair), self.hair, shown_of(self.hair)])
        edges = {"hair": names["variant"][-1], "reference": names["reference"][-1]}
        table = {"type": "measure_patches", "in": edges, "patches": self.sample.patches}
        shot = self.shot.edited(with_node(merged, ERROR, table))
        before = [edge.node for name in names.values() for edge in shot.nodes[name[0]].edges.values()]
        fault = self._carry_out(text, shot, before, self.sample.simulated)
        fault = fault or self._carry_out(f"reference: {finest.text}", shot, names["reference"], self.sample.frames)
        fault = fault or self._carry_out(text, shot, [ERROR], self.sample.frames)
        return failed(fault) if fault else self._read(shot, names["variant"])

    def _carry_out(self, text: str, shot: Shot, nodes: Sequence[str], frames: Sequence[int]) -> str:
        """Run a shot up to some nodes; returns the fault. One run at a time, so that times are those of one."""
        outcome = self._run(text, shot, nodes, frames)
        if outcome.interrupted:
            raise Interrupted
        for failure in outcome.failures:
            if failure.kind in ("disk", "crash", "publish"):  # which are no property of a model
                raise BadInput(f"{text}: {failure}", where=self.shot.path)
        return next((str(failure.message) for failure in outcome.failures), "")

    def _read(self, shot: Shot, names: Sequence[str]) -> Measured:
        """Read what nodes that simulate hair, and interpolate or carry it, were off by, and what they took."""
        results = Results(shot, self.sample.frames)
        frames = [frame for frame in self.sample.frames if frame > self.sample.begin]
        plugs = shot.nodes[names[0]].edges.items()
        others = [results.seconds(edge.node, frames) for plug, edge in plugs if plug.split(".")[0] in BODIES]
        whole = [name for name in names if shot.nodes[name].type.name == "simulate_particles"]
        hair = [results.seconds(name, frames) for name in names if name not in whole]
        others += [results.seconds(name, frames) for name in whole]
        seconds = seconds_per_frame(hair, others, len(frames), self.scale)
        return measured_of(results.value(ERROR), self.tolerance, seconds)


def sampled(tables: Tables, hair: str, sample: Sample) -> Tables:
    """Return the tables of a graph with its hair simulated for a sample only; pure."""
    groom = tables[hair]["in"]["groom"]
    settings = {"strands": sample.strands, "patches": sample.patches, "number": sample.number}
    table = {"type": "sample_groom", "in": {"groom": groom}, **settings}
    return with_node(tables, SAMPLE, table, instead=groom) | {"frames": [sample.begin, sample.last]}
