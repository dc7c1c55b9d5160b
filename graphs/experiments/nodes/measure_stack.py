"""Stability of stacks in contact between strands."""

from typing import Annotated, NamedTuple

from hairpipe.engine import node
from hairpipe.laws.settings import Collisions
from hairpipe.units import Gt, Interval, Seconds
from hairpipe.values import Table

Layers = tuple[Annotated[int, Interval(ge=1, le=200)], ...]
Sweeps = tuple[Annotated[int, Interval(ge=1, le=100)], ...]


class Stack(NamedTuple):
    """Convergence of the solvers at the landing of a stack, and the final state."""

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
    """Simulate crossed rods of two points stacked on a fixed row, with the coupled and the published solver.

    collisions  contact between the rods
    step        time step; the default is about one stage of the default integrator at 1/240 s
    layers      number of layers of each stack
    sweeps      numbers of sweeps of the published solver, in the second table
    iterations  iterations in the first table: sweeps over all pairs, or steps of conjugate gradients
    seconds     duration of the run, for stacks to come to rest
    """
    from hairpipe.errors import BadInput
    from hairpipe.graphs.experiments.studies.contact.stack import landing_table, standing_table

    if not collisions.thickness.is_constant:
        raise BadInput("all rods have one thickness", where="collisions.thickness", right="a number")
    landing = landing_table(collisions, step, layers, iterations)
    return Stack(landing, standing_table(collisions, step, layers, sweeps, seconds))
