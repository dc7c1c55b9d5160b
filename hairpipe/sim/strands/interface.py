"""What the solver asks of a model of a strand, and how a model is registered.

A model is a NamedTuple of arrays (`StrandModel`) and a few kernels (`ModelKind`). Kernels of the solver call
`add_forces`, `spring_constant`, `springs_from` and `shape_of` below; numba asks here for what the model of that type
has registered, and inlines it. A kernel that is loaded from the cache needs no registration.
"""

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any, Protocol, Self

import numpy as np
from numba import types
from numba.core.extending import overload

from hairpipe.data import Groom
from hairpipe.sim.layout import Layout, Shape
from hairpipe.sim.material import Material
from hairpipe.sim.strands.construction import Construction


class StrandModel(Protocol):
    """Constants of all strands; rows are particles, strand after strand, block after block (see `Layout`).

    shape  how the particles of a strand stand in its rows
    """

    shape: Shape

    @property
    def first(self) -> np.ndarray:
        """Rows of block b are first[b]:first[b+1], (blocks+1,) int64."""
        ...

    @property
    def mass(self) -> np.ndarray:
        """Of particles [kg], (rows, W)."""
        ...

    @property
    def inverse_lengths(self) -> np.ndarray:
        """1 / l0 of the springs to the next particles [1/m], 0 past the end, (rows, springs, W)."""
        ...

    @property
    def constants(self) -> np.ndarray:
        """Of the springs of every strand, that of its edges first, EA [N], (blocks, kinds, W)."""
        ...

    def _replace(self, **changes: Any) -> Self: ...


Build = Callable[[Layout, Groom, Material, Construction], tuple[Any, np.ndarray]]


@dataclass(frozen=True, eq=False)
class ModelKind:
    """A kind of strand model.

    name    by which a graph asks for it
    model   the NamedTuple, a `StrandModel`
    shape   of its strands
    build   makes the models of a groom in a layout, and their particles at rest [m], (rows, 3, W) float64; raises
            BadInput for grooms that it cannot be
    warn    warns of what the model does not take over of a material, once a shot

    The others are kernels that numba inlines, see the functions of those names below.
    """

    name: str
    model: type
    shape: Shape
    build: Build
    add_forces: Any
    springs_from: Any
    spring_constant: Any
    warn: Callable[[Groom, Material], None] = lambda groom, material: None


_KINDS: dict[type, ModelKind] = {}


def register_model(kind: ModelKind) -> ModelKind:
    """Make a kind of model known to the solver's kernels, and return it."""
    _KINDS[kind.model] = kind
    return kind


def kind_of(model: StrandModel) -> ModelKind:
    """Return the kind of a model; KeyError where it is not registered."""
    return _KINDS[type(model)]


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
    """Number of springs from particle p to those after it, of a strand of so many particles."""
    raise NotImplementedError


def spring_constant(model: Any, block: Any, p: Any, offset: Any) -> Any:
    """Force per unit strain [N] of the spring from particle p to p + offset, in lanes."""
    raise NotImplementedError


def _registered(numba_type: types.Type) -> ModelKind | None:
    return _KINDS.get(getattr(numba_type, "instance_class", type(None)))


@overload(add_forces, strict=False)
def _add_forces(
    model: Any, A: Any, b: Any, x: Any, v: Any, T: Any, p: Any, block: Any, h: Any, hh: Any, damping: Any
) -> Callable | None:
    kind = _registered(model)
    if kind is None:
        return None
    kernel = kind.add_forces
    return lambda model, A, b, x, v, T, p, block, h, hh, damping: kernel(model, A, b, x, v, T, p, block, h, hh, damping)


@overload(shape_of, strict=False)
def _shape_of(model: Any) -> Callable | None:
    kind = _registered(model)
    if kind is None:
        return None
    shape = kind.shape
    return lambda model: shape


@overload(springs_from, strict=False)
def _springs_from(model: Any, p: Any, count: Any) -> Callable | None:
    kind = _registered(model)
    if kind is None:
        return None
    kernel = kind.springs_from
    return lambda model, p, count: kernel(p, count)


@overload(spring_constant, strict=False)
def _spring_constant(model: Any, block: Any, p: Any, offset: Any) -> Callable | None:
    kind = _registered(model)
    if kind is None:
        return None
    kernel = kind.spring_constant
    return lambda model, block, p, offset: kernel(model, block, p, offset)
