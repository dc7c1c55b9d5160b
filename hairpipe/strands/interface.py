"""The interface of strand models to the solver, and their registration.

A model is a NamedTuple of arrays (`StrandModel`) and a few kernels (`ModelKind`). Kernels of the solver call
`add_forces`, `spring_constant`, `springs_from`, `predict`, `hold_tip`, `follow_solve`, `least_pivot`, `largest_turn`
and `shape_of` below; numba looks up the functions registered for the type of the model, and inlines them. A kernel
loaded from the cache needs no registration.

Settings of the construction of a strand's network, with proven defaults.
"""

from collections.abc import Callable
from dataclasses import dataclass
from enum import IntEnum
from functools import wraps
from typing import Any, NamedTuple, Protocol, Self

import numpy as np
from numba.core.extending import overload

from hairpipe.geometry.compile import inlined
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


@inlined
def _predict_nothing(model, T, span, stays):
    """Leave what the model remembers as it is."""


@inlined
def _hold_nothing(model, block, x, T, held):
    """Leave what the model remembers as it is."""


@inlined
def _follow_nothing(model, block, at, dx, b, h):
    """Remember nothing of a solve but tensions."""


@inlined
def _least_zero(model, block, hh):
    """Accept every positive pivot."""
    return 0.0 * hh


@inlined
def _turn_nothing(model, block, b, h):
    """Turn no frame, where there are none."""
    return 0.0 * h


Build = Callable[[Layout, Groom, Fibres, Construction, float], tuple[Any, np.ndarray]]
FindEquilibrium = Callable[[Any, np.ndarray, np.ndarray], tuple[np.ndarray, np.ndarray, np.ndarray]]


@dataclass(frozen=True, eq=False)
class ModelKind:
    """A kind of strand model.

    name    name in a graph
    model   the NamedTuple, a `StrandModel`
    shape   shape of its strands
    build   makes the models of a groom in a layout, with a share of its curvature at rest, and their particles in the
            shape of the groom [m], (rows, 3, W) float64; raises BadInput for unsuitable grooms
    warn    warns once per shot of properties of the material that the model ignores

    equilibrium   finds the rest state of strands in equilibrium at x [m], (rows, 3, W), under gravity [m/s^2], (3,):
                  rest state and T, like `inverse_lengths`, and largest strain of an edge, (blocks, W); None: springs
    single_limit  number of explicit steps per step up to which single precision is chosen, see `shot/simulate.py`;
                  0, for a model without measurements: never

    The other fields are kernels that numba inlines, see the functions of those names below.
    """

    name: str
    model: type
    shape: Shape
    build: Build
    add_forces: Any
    springs_from: Any
    spring_constant: Any
    predict: Any = _predict_nothing
    hold_tip: Any = _hold_nothing
    follow_solve: Any = _follow_nothing
    least_pivot: Any = _least_zero
    largest_turn: Any = _turn_nothing
    warn: Callable[[Groom, Fibres], None] = lambda groom, fibres: None
    equilibrium: FindEquilibrium | None = None
    single_limit: float = 0.0


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


def by_model(declaration: Callable) -> Callable:
    """Decorate the declaration of a kernel: numba compiles that of the model's kind in its place, see `for_models`.

    A call from Python raises TypeError.
    """

    @wraps(declaration)
    def declared(*_: Any) -> None:
        raise TypeError(f"{declaration.__name__} is a kernel that numba selects by the model: call it in compiled code")

    return declared


@by_model
def add_forces(model: Any, system: Any, at: Any, p: Any, block: Any, terms: Any) -> None:
    """Add the forces that begin at particle p of a block: h f to the right-hand side, hh K + h D to the matrix.

    system  matrix and right-hand side, A and b
    at      positions [m] and velocities [m/s] of the linearisation, (particles, 3, W), and the tensions in the
            stiffness [N], (particles, springs, W): x, v and T
    terms   a Terms
    """


@by_model
def predict(model: Any, T: Any, span: Any, stays: Any) -> Any:
    """Advance the stored values of a block through a stage [s], except in fixed lanes, in place."""


@by_model
def hold_tip(model: Any, block: Any, x: Any, T: Any, held: Any) -> Any:
    """Update the stored values of a block, T, for held tips; arguments as in `Stage`; in place."""


@by_model
def follow_solve(model: Any, block: Any, at: Any, dx: Any, b: Any, h: Any) -> Any:
    """Update the stored values of a block, T of the iterate `at`, after a solve that moves it by dx, in place.

    b   change of velocity, and of other unknowns, (rows, unknowns, W); h  its factor [s]
    """


@by_model
def least_pivot(model: Any, block: Any, hh: Any) -> Any:
    """Pivot of an angle up to which the matrix of a strand counts as indefinite, in lanes; hh  h^2 [s^2]."""


@by_model
def largest_turn(model: Any, block: Any, b: Any, h: Any) -> Any:
    """Largest turn of a material frame by a solution b of a block, in lanes; 1 is the most that a solve may make.

    Arguments as of `follow_solve`.
    """


@by_model
def shape_of(model: Any) -> Any:
    """Shape of the model, as constants of the machine code."""


@by_model
def springs_from(model: Any, p: Any, count: Any) -> Any:
    """Number of springs from particle p to those after it, of a strand of so many particles."""


@by_model
def spring_constant(model: Any, block: Any, p: Any, offset: Any) -> Any:
    """Force per unit strain [N] of the spring from particle p to p + offset, in lanes."""


def for_models(stub: Callable) -> Callable:
    """Decorate a function that gives, for a kind of model, what numba compiles where a stub is called with a model."""

    def decorate(implementation: Callable[[ModelKind], Callable]) -> Callable:
        def choose(model: Any, *_: Any) -> Callable | None:
            kind = _KINDS.get(getattr(model, "instance_class", type(None)))
            return None if kind is None else implementation(kind)

        overload(stub, strict=False)(choose)
        return implementation

    return decorate


@for_models(add_forces)
def _add_forces(kind: ModelKind) -> Callable:
    kernel = kind.add_forces
    return lambda model, system, at, p, block, terms: kernel(model, system, at, p, block, terms)


@for_models(predict)
def _predict(kind: ModelKind) -> Callable:
    kernel = kind.predict
    return lambda model, T, span, stays: kernel(model, T, span, stays)


@for_models(hold_tip)
def _hold_tip(kind: ModelKind) -> Callable:
    kernel = kind.hold_tip
    return lambda model, block, x, T, held: kernel(model, block, x, T, held)


@for_models(follow_solve)
def _follow_solve(kind: ModelKind) -> Callable:
    kernel = kind.follow_solve
    return lambda model, block, at, dx, b, h: kernel(model, block, at, dx, b, h)


@for_models(least_pivot)
def _least_pivot(kind: ModelKind) -> Callable:
    kernel = kind.least_pivot
    return lambda model, block, hh: kernel(model, block, hh)


@for_models(largest_turn)
def _largest_turn(kind: ModelKind) -> Callable:
    kernel = kind.largest_turn
    return lambda model, block, b, h: kernel(model, block, b, h)


@for_models(shape_of)
def _shape_of(kind: ModelKind) -> Callable:
    shape = kind.shape
    return lambda model: shape


@for_models(springs_from)
def _springs_from(kind: ModelKind) -> Callable:
    kernel = kind.springs_from
    return lambda model, p, count: kernel(p, count)


@for_models(spring_constant)
def _spring_constant(kind: ModelKind) -> Callable:
    kernel = kind.spring_constant
    return lambda model, block, p, offset: kernel(model, block, p, offset)
