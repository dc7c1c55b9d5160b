"""Strands to measure on: straight hair that starts to hang, the same in every run."""

from typing import NamedTuple

import numpy as np
from numpy.typing import DTypeLike

from hairpipe.bench.assembly import assembly_of
from hairpipe.bench.counting import Work, count_work
from hairpipe.sim.integrators.tr_bdf2 import advance_all
from hairpipe.sim.lanes import width
from hairpipe.sim.layout import lay_out
from hairpipe.sim.material import Material
from hairpipe.sim.models.construction import Construction
from hairpipe.sim.models.network import SHAPE, Network, build_network
from hairpipe.sim.spring_form import SpringForm
from hairpipe.sim.stage import Rule, run_stage, run_stages

LENGTH, STEP = 0.3, 1 / 240
"""Of a strand [m]; of time [s]."""
RULE = Rule(int(SpringForm.multiplier), 0.0, 0.03, 1, np.array([0.0, -9.81, 0.0]), 8.0)
"""What the default integrator asks of its stages."""


class Strands(NamedTuple):
    """Hair, and room for its state.

    rest  [m], (rows, 3, W)
    x, v, a, T  as `integrators.interface.Motion` has them
    ends, held  as `integrators.interface.Step` has them, for one stage
    """

    model: Network
    rest: np.ndarray
    x: np.ndarray
    v: np.ndarray
    a: np.ndarray
    T: np.ndarray
    ends: np.ndarray
    held: np.ndarray

    @property
    def particles(self) -> int:
        """Number of particles, those of lanes that only repeat a strand too."""
        return self.x.shape[0] * self.x.shape[2]

    def restart(self) -> None:
        """Put all strands at rest."""
        self.x[:] = self.rest
        for array in (self.v, self.a, self.T):
            array[:] = 0.0


def hang(count: int, segments: int, dtype: DTypeLike) -> Strands:
    """Make so many strands."""
    # Not along an axis, where products with zero would be what is measured.
    strand = np.linspace(0.0, LENGTH, segments + 1)[:, None] * np.array([0.1, -0.95, 0.2])
    offsets = np.arange(count + 1, dtype=np.int32) * (segments + 1)
    layout = lay_out(offsets, SHAPE, dtype)
    model, rest = build_network(layout, np.tile(strand, (count, 1)), Material(), Construction())
    roots = rest.reshape(layout.blocks, -1, *rest.shape[1:])[:, : SHAPE.clamped]
    hair = Strands(
        model,
        rest,
        *(np.empty_like(rest) for _ in range(4)),
        np.concatenate([roots, np.zeros_like(roots)], axis=1),
        np.zeros((0, layout.width), layout.dtype),
    )
    hair.restart()
    return hair


def step(hair: Strands) -> None:
    """Advance hair by one step of the default integrator, in place."""
    ends = np.stack([hair.ends, hair.ends])
    advance_all(hair.model, hair.x, hair.v, hair.a, hair.T, ends, hair.held, STEP, RULE)


def solve(hair: Strands) -> None:
    """Run one linearly implicit stage on all hair, in place."""
    run_stages(hair.model, hair.x, hair.v, hair.T, hair.rest, hair.a, hair.ends, hair.held, STEP / 4, RULE)


def work_of_a_solve(segments: int, dtype: DTypeLike) -> Work:
    """Count what a solve does, per particle."""
    return count_work(run_stage, *one_block(segments, dtype)).per(SHAPE.count(segments))


def machine_code(dtype: DTypeLike) -> str:
    """Give the assembly of a solve."""
    return assembly_of(run_stage, *one_block(2, dtype))


def one_block(segments: int, dtype: DTypeLike) -> tuple:
    """Arguments of a solve of one block."""
    hair = hang(width(dtype), segments, dtype)
    before = hair.rest.copy()
    return hair.model, 0, hair.x, hair.v, hair.T, hair.rest, hair.a, before, hair.ends[0], hair.held, STEP / 4, RULE
