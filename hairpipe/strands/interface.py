"""The interface of strand models to the solver, and their registration.

A model is a NamedTuple of arrays (`StrandModel`) and a few kernels (`ModelKind`). Kernels of the solver call those that
are declared at the end of this file; numba looks up those of the type of the model, and inlines them. A kernel loaded
from the cache needs no registration.
"""

from collections.abc import Callable
from dataclasses import dataclass
from enum import IntEnum
from functools import cached_property, update_wrapper
from operator import attrgetter
from typing import Any, NamedTuple, Protocol, Self

import numpy as np
from numba import types
from numba.core.dispatcher import Dispatcher

from hairpipe.geometry.compile import Inlined, inlined
from hairpipe.laws.settings import Construction
from hairpipe.strands.layout import Layout, Shape
from hairpipe.strands.material import Fibres
from hairpipe.values import Groom


class StrandModel(Protocol):
    """Constants of all strands; rows are particles, strand after strand, block after block (see `Layout`).

    shape  order of the particles of a strand in its rows
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
        """1 / l0 of the springs to the next particles [1/m], 0 past the end, (rows, springs, W).

        Other rest values of a strand may follow the springs; results of solves (`Iterate.T`) have the same shape.
        """
        ...

    @property
    def constants(self) -> np.ndarray:
        """Of the springs that begin at a particle, that of its edge first, EA [N], (rows, kinds, W); of all rows."""
        ...

    def _replace(self, **changes: Any) -> Self: ...


class StiffnessPart(IntEnum):
    """The part of the stiffness in the matrix of a model that may be indefinite.

    projected  positive semidefinite part of every vertex
    full       all, except compression of edges
    exact      the second derivative of the energy
    """

    projected = 0
    full = 1
    exact = 2


Build = Callable[[Layout, Groom, Fibres, Construction, float | np.ndarray], tuple[Any, np.ndarray]]
FindEquilibrium = Callable[[Any, np.ndarray, np.ndarray], tuple[np.ndarray, np.ndarray, np.ndarray]]


@dataclass(frozen=True, eq=False)
class ModelKind:
    """A kind of strand model.

    name    name in a graph
    model   the NamedTuple, a `StrandModel`
    shape   shape of its strands
    build   makes the models of a groom in a layout, with a share of its curvature at rest, one or at points, (P,), and
            their particles in the shape of the groom [m], (rows, 3, W) float64; raises BadInput for unsuitable grooms
    warn    warns once per shot of properties of the material that the model ignores

    equilibrium   finds the rest state of strands in equilibrium at x [m], (rows, 3, W), under gravity [m/s^2], (3,):
                  rest state and T, like `inverse_lengths`, and largest strain of an edge, (blocks, W); None: springs
    single_limit  number of explicit steps per step up to which single precision is chosen, see `shot/simulate.py`;
                  0, for a model without measurements: never

    The other fields are kernels, see the declarations of those names below; None: the body of the declaration.
    """

    name: str
    model: type
    shape: Shape
    build: Build
    add_forces: Inlined
    springs_from: Inlined
    spring_constant: Inlined
    predict: Dispatcher | None = None
    hold_tip: Dispatcher | None = None
    follow_solve: Dispatcher | None = None
    least_pivot: Dispatcher | None = None
    largest_turn: Dispatcher | None = None
    warn: Callable[[Groom, Fibres], None] = lambda groom, fibres: None
    equilibrium: FindEquilibrium | None = None
    single_limit: float = 0.0

    @cached_property
    def shape_of(self) -> Inlined:
        """The shape, as constants of the machine code."""
        shape = self.shape
        return inlined(lambda model: shape)


_KINDS: dict[type, ModelKind] = {}


def register_model(kind: ModelKind) -> ModelKind:
    """Make a kind of model known to the solver's kernels, and return it."""
    _KINDS[kind.model] = kind
    return kind


def may_be_lost(model: StrandModel) -> bool:
    """Whether the matrix of a model may be indefinite: its solves then take the semidefinite part."""
    return model.shape.unknowns > 3


def kind_of(model: StrandModel) -> ModelKind:
    """Return the kind of a model; KeyError where it is not registered."""
    return _KINDS[type(model)]


class Terms(NamedTuple):
    """Factors of forces and stiffness, and the parts to include.

    h        step [s]
    hh       h^2, or 0 if the stiffness is omitted [s^2]
    damping  damping of the springs, a fraction of critical damping
    part     part of the stiffness, a StiffnessPart, for models whose matrix may be indefinite
    """

    h: Any
    hh: Any
    damping: float
    part: int


class ByModel:
    """A kernel that numba selects where it compiles a call, by the type of the model, which is the first argument.

    declaration  its name and arguments; its body is the kernel of the models for which none is chosen
    chosen       gives the kernel of a kind of model, None: the body

    A call from Python raises TypeError.
    """

    def __init__(self, declaration: Callable, chosen: Callable[[ModelKind], Dispatcher | None]) -> None:
        self.body = inlined(declaration)
        self.chosen = chosen
        update_wrapper(self, declaration)

    def kernel_of(self, model: type) -> Dispatcher:
        """Return the kernel of a type of model; KeyError where it is not registered."""
        return self.chosen(_KINDS[model]) or self.body

    def __call__(self, *_: Any) -> Any:
        raise TypeError(
            f"{self.body.py_func.__name__} is a kernel that numba selects by the model: call it in compiled code"
        )

    # What numba's type of a compiled function asks for.

    is_compiling = False

    @property
    def _numba_type_(self) -> types.Type:
        return types.Dispatcher(self)

    def get_call_template(self, args: Any, kws: Any) -> Any:
        return self.kernel_of(args[0].instance_class).get_call_template(args, kws)

    def get_overload(self, args: Any) -> Any:
        return self.kernel_of(args[0].instance_class).get_overload(args)


def inlined_by_model(declaration: Callable) -> ByModel:
    """Decorate the declaration of a kernel that is a field of `ModelKind`."""
    return ByModel(declaration, attrgetter(declaration.__name__))


@inlined_by_model
def add_forces(model, system, at, p, block, terms):
    """Add the forces that begin at particle p of a block: h f to the right-hand side, hh K + h D to the matrix.

    system  matrix and right-hand side, A and b
    at      positions [m] and velocities [m/s] of the linearisation, (particles, 3, W), and the tensions in the
            stiffness [N], (particles, springs, W): x, v and T
    terms   a Terms
    """


@inlined_by_model
def predict(model, T, span, stays):
    """Advance the stored values of a block through a stage [s], except in fixed lanes, in place."""


@inlined_by_model
def hold_tip(model, block, x, T, held):
    """Update the stored values of a block, T, for held tips; arguments as in `Stage`; in place."""


@inlined_by_model
def follow_solve(model, block, at, dx, b, h):
    """Update the stored values of a block, T of the iterate `at`, after a solve that moves it by dx, in place.

    b   change of velocity, and of other unknowns, (rows, unknowns, W); h  its factor [s]
    """


@inlined_by_model
def least_pivot(model, block, hh):
    """Pivot of an angle up to which the matrix of a strand counts as indefinite, in lanes; hh  h^2 [s^2]."""
    return 0.0 * hh


@inlined_by_model
def largest_turn(model, block, b, h):
    """Largest turn of a material frame by a solution b of a block, in lanes; 1 is the most that a solve may make.

    Arguments as of `follow_solve`.
    """
    return 0.0 * h


@inlined_by_model
def shape_of(model):
    """Shape of the model, as constants of the machine code."""


@inlined_by_model
def springs_from(model, p, count):
    """Number of springs from particle p to those after it, of a strand of so many particles."""


@inlined_by_model
def spring_constant(model, block, p, offset):
    """Force per unit strain [N] of the spring from particle p to p + offset, in lanes."""
