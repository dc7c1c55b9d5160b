"""Whether contact between hairs carries a stack."""

from typing import Annotated, NamedTuple

from hairpipe.data import Table
from hairpipe.graph import node
from hairpipe.sim.settings import Collisions
from hairpipe.units import Gt, Interval, Seconds

Layers = tuple[Annotated[int, Interval(ge=1, le=200)], ...]
Sweeps = tuple[Annotated[int, Interval(ge=1, le=100)], ...]


class Stack(NamedTuple):
    """How the solvers converge when a stack lands, and what stands in the end."""

    landing: Table
    standing: Table


@node(frames="once")
def measure_stack(
    *,
    collisions: Collisions = Collisions(),  # noqa: B008 (frozen)
    step: Annotated[Seconds, Gt(0.0)] = 1 / 800,
    layers: Layers = (5, 10, 20, 40),
    sweeps: Sweeps = (3, 10, 30, 100),
    iterations: Annotated[int, Interval(ge=1, le=10_000)] = 1000,
    seconds: Annotated[Seconds, Gt(0.0)] = 0.5,
) -> Stack:
    """Rods of two points laid crosswise on a fixed row, under the coupled and the published solver.

    collisions  of the rods
    step        of time; the default is about the weight of a stage of the default integrator at 1/240 s
    layers      of each stack
    sweeps      of the published solver, in the second table
    iterations  shown in the first table: sweeps over all pairs, or of conjugate gradients
    seconds     that stacks are given to come to rest in
    """
    from hairpipe.graphs.experiments.studies.contact.stack import landing_table, standing_table

    landing = landing_table(collisions, step, layers, iterations)
    return Stack(landing, standing_table(collisions, step, layers, sweeps, seconds))
