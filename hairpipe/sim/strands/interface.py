"""What the solver asks of a model of a strand.

A model is a NamedTuple of arrays. Its rows are particles, strand after strand, block after block; a block is as many
strands of equal count as there are lanes (W). Whatever the model, it has

    shape            how particles stand in the rows, a Shape
    first            rows of block b are first[b]:first[b+1], (blocks+1,) int64
    mass             [kg], (rows, W)
    inverse_lengths  1 / l0 of the springs to the next particles [1/m], 0 past the end, (rows, springs, W)

and three kernels, chosen by numba from the model's type: `add_forces`, `spring_constant`, and `springs_from`.
"""

from typing import Any, NamedTuple

from numba import types


class Shape(NamedTuple):
    """How the particles of a strand stand in its rows.

    reach    a force couples a particle to so many after it
    clamped  so many at the root are held by the body; the last of them is m_0, the first point of the groom
    stride   from one particle on the axis to the next
    """

    reach: int
    clamped: int
    stride: int

    def count(self, segments: int) -> int:
        """Number of particles of a strand."""
        return self.stride * segments + self.clamped

    @property
    def axis(self) -> slice:
        """Where the points of the groom stand among the particles."""
        return slice(self.clamped - 1, None, self.stride)


def add_forces(
    model: Any, A: Any, b: Any, x: Any, v: Any, T: Any, p: Any, block: Any, h: Any, hh: Any, damping: Any
) -> None:
    """Add what begins at particle p of a block: h f to b, and hh K + h D to the rows of A.

    x, v     positions [m] and velocities [m/s] where the system is linearised, (particles, 3, W)
    T        tensions that the stiffness is to hold [N], (particles, springs, W)
    hh       h^2, or 0 where the stiffness is left out
    damping  of the springs, a fraction of critical damping
    """
    raise NotImplementedError


def shape_of(model: Any) -> Any:
    """Shape of the model, as constants of the machine code."""
    raise NotImplementedError


def springs_from(model: Any, p: Any, count: Any) -> Any:
    """Number of springs from particle p to those after it."""
    raise NotImplementedError


def spring_constant(model: Any, block: Any, p: Any, offset: Any) -> Any:
    """Force per unit strain [N] of the spring from particle p to p + offset, in lanes."""
    raise NotImplementedError


def is_model(numba_type: types.Type, model: type) -> bool:
    """Whether numba's type is that of the model's NamedTuple."""
    return isinstance(numba_type, types.BaseNamedTuple) and getattr(numba_type, "instance_class", None) is model
