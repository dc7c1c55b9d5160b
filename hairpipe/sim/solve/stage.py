"""Records that travel whole into the kernels of a stage."""

from typing import NamedTuple

import numpy as np

from hairpipe.sim.strands.interface import StiffnessPart


class Rule(NamedTuple):
    """What all stages of a simulation have in common.

    form        a SpringForm
    damping     of the springs, a fraction of critical damping
    guard       strain of an edge at the guess beyond which its strand restarts as the stage began, at its root, in two
                iterations, or where something acts on hair, from where `guess_stages` carries it; inf: never
    iterations  of Newton's method a stage
    gravity     [m/s^2], (3,)
    drag        against still air [1/s]
    part        of the stiffness of models whose matrix may be indefinite, a StiffnessPart
    """

    form: int
    damping: float
    guard: float
    iterations: int
    gravity: np.ndarray
    drag: float
    part: int = int(StiffnessPart.full)


class Stage(NamedTuple):
    """One stage of an integrator: x = xh + h v, M (v - vh) = h f(x, v); of all strands, or of one block.

    xh, vh  explicit parts of position [m] and velocity [m/s], (rows, 3, W)
    before  positions where the stage began, same shape; a strand that the guess strains too much restarts there
    began   velocities there, same shape; the guess, or what drag and friction go by where the guess is another
    ends    held particles at its end: those at the root, then those at the tip [m], (blocks, 2 clamped, 3, W)
    held    1 where the tip is held, 0 where it is free, (blocks, W); no rows where all are free
    h       weight of the end, for every strand [s], (blocks, W)
    time    that bodies and wind are those of, at its end but in the nine steps, since the previous frame [s]
    span    that the stage covers [s]
    """

    xh: np.ndarray
    vh: np.ndarray
    before: np.ndarray
    began: np.ndarray
    ends: np.ndarray
    held: np.ndarray
    h: np.ndarray
    time: float
    span: float


class Iterate(NamedTuple):
    """Where Newton's method is, of all strands or of one block; kernels change it in place.

    x, v  positions [m] and velocities [m/s], (rows, 3, W)
    T     tensions of the springs as the last solve found them [N], and what else a model remembers of it, in the shape
          of its inverse_lengths, (rows, springs, W)
    """

    x: np.ndarray
    v: np.ndarray
    T: np.ndarray


class System(NamedTuple):
    """Banded systems of strands, of all or of one block.

    A  factors, (rows, row_size, W), which may have less precision; no rows where they are not kept
    b  right-hand side, then the change of velocity [m/s], and of what else a row has, (rows, unknowns, W)
    """

    A: np.ndarray
    b: np.ndarray
