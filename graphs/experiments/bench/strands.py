"""Strands to measure on: straight hair that starts to hang, the same in every run."""

from typing import NamedTuple

import numpy as np
from numpy.typing import DTypeLike

from hairpipe.geometry.simd import width
from hairpipe.graphs.experiments.bench.arithmetic.assembly import assembly_of
from hairpipe.graphs.experiments.bench.arithmetic.counting import Work, count_work
from hairpipe.groom.strands import unbound
from hairpipe.laws.settings import Construction
from hairpipe.laws.stretch import SpringForm
from hairpipe.solve.boundary import Clamp, ClampPath
from hairpipe.solve.implicit_stage import run_stage, run_stages
from hairpipe.solve.integrator import everywhere
from hairpipe.solve.integrators import TrBdf2
from hairpipe.solve.stage import Iterate, Rule, Stage, State, Step
from hairpipe.solve.surroundings import Surroundings
from hairpipe.strands.interface import StrandModel
from hairpipe.strands.layout import lay_out
from hairpipe.strands.material import Material, fibres_of
from hairpipe.strands.registry import ModelName, strand_models

LENGTH = 0.3
STEP = 1 / 240
"""Length of a strand [m] and step of time [s]."""
RULE = Rule(int(SpringForm.multiplier), 0.0, 0.03, 1, np.array([0.0, -9.81, 0.0]), 8.0)
"""What the default integrator asks of its stages."""


class Strands(NamedTuple):
    """Hair, and room for its state.

    rest     [m], (rows, 3, W)
    path     of its roots, which stand still
    weights  of the end of a stage [s], (blocks, W)
    """

    model: StrandModel
    rest: np.ndarray
    motion: State
    path: ClampPath
    around: Surroundings
    weights: np.ndarray

    @property
    def particles(self) -> int:
        """Number of particles, those of lanes that only repeat a strand too."""
        return self.rest.shape[0] * self.rest.shape[2]

    def restart(self) -> None:
        """Put all strands at rest."""
        self.motion.x[:] = self.rest
        for array in (self.motion.v, self.motion.a, self.motion.T):
            array[:] = 0.0


def hang(count: int, segments: int, dtype: DTypeLike, model: ModelName = "network") -> Strands:
    """Make so many strands of a model."""
    # Not along an axis, where products with zero would be what is measured.
    strand = np.linspace(0.0, LENGTH, segments + 1)[:, None] * np.array([0.1, -0.95, 0.2])
    groom = unbound(np.tile(strand, (count, 1, 1)), np.tile(np.eye(3, 4), (count, 1, 1)))
    kind = strand_models()[model]
    layout = lay_out(groom.offsets, kind.shape, dtype)
    built, rest = kind.build(layout, groom, fibres_of(groom, Material()), Construction(), 1.0)
    rest = rest.astype(dtype)
    roots = rest.reshape(layout.blocks, -1, *rest.shape[1:])[:, : kind.shape.clamped]
    ends = np.concatenate([roots, np.zeros_like(roots)], axis=1)
    still = Clamp(ends, np.zeros_like(ends), np.zeros((0, layout.width), layout.dtype))
    x, v, a, T = *(np.empty_like(rest) for _ in range(3)), np.empty_like(built.inverse_lengths)
    motion = State(x, v, a, T, np.zeros(layout.strands.shape, bool))
    weights = everywhere(built, rest, STEP / 4)
    hair = Strands(built, rest, motion, ClampPath(still, still, STEP), Surroundings(built, layout), weights)
    hair.restart()
    return hair


def step(hair: Strands) -> None:
    """Advance hair by one step of the default integrator, in place."""
    TrBdf2(RULE).advance(hair.model, hair.motion, Step(hair.path, 0.0, STEP), hair.around)


def solve(hair: Strands) -> None:
    """Run one linearly implicit stage on all hair, in place."""
    run_stages(hair.model, _iterate(hair), _stage(hair, hair.path.start.positions, hair.rest), RULE)


def work_of_a_solve(segments: int, dtype: DTypeLike, model: ModelName = "network") -> Work:
    """Count what a solve does, per particle."""
    return count_work(run_stage, *one_block(segments, dtype, model)).per(particles_of(model, segments))


def particles_of(model: ModelName, segments: int) -> int:
    """Return the number of particles of a strand."""
    return strand_models()[model].shape.count(segments)


def machine_code(dtype: DTypeLike, model: ModelName = "network") -> str:
    """Return the assembly of a solve."""
    return assembly_of(run_stage, *one_block(2, dtype, model))


def one_block(segments: int, dtype: DTypeLike, model: ModelName = "network") -> tuple:
    """Arguments of a solve of one block."""
    hair = hang(width(dtype), segments, dtype, model)
    return hair.model, 0, _iterate(hair), _stage(hair, hair.path.start.positions[0], hair.rest.copy()), RULE


def _iterate(hair: Strands) -> Iterate:
    """Where a stage starts: its arrays are those of the motion."""
    return Iterate(hair.motion.x, hair.motion.v, hair.motion.T)


def _stage(hair: Strands, ends: np.ndarray, before: np.ndarray) -> Stage:
    """Make a stage that begins at rest, before, with ends of all blocks or of one [m]."""
    a = hair.motion.a
    return Stage(hair.rest, a, before, a, ends, hair.path.start.tips, hair.weights, STEP, STEP)
