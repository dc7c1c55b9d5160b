"""Adds linearised forces to the banded system of a block.

A value that several forces change is read and written once: memory access, not arithmetic, dominates the time of
assembly.
"""

from hairpipe.geometry import sym3
from hairpipe.geometry.banded import add, add_coupling, add_diagonal
from hairpipe.geometry.compile import inlined
from hairpipe.geometry.vec3 import minus, plus, scaled


@inlined
def add_vector(b, p, f):
    """Add a vector to the right-hand side of particle p, in place."""
    add(b, p, 0, f[0])
    add(b, p, 1, f[1])
    add(b, p, 2, f[2])


@inlined
def add_spring(A, b, p, offset, spring):
    """Add what `linearise_spring` gives for particles p and p + offset, in place."""
    f, K = spring
    add_vector(b, p, f)
    add_vector(b, p + offset, scaled(-1.0, f))
    add_diagonal(A, p, *K)
    add_diagonal(A, p + offset, *K)
    add_coupling(A, p, offset, sym3.times(-1.0, K))


@inlined
def add_tetrahedron(A, b, p, altitude, spring1, spring2, spring3):
    """Add an altitude of particles p to p + 3, and the springs from p to each of the others, in place.

    altitude  of `linearise_altitude`; springs  of `linearise_spring`
    """
    (g0, g1, g2, g3), f, K = altitude
    (f1, K1), (f2, K2), (f3, K3) = spring1, spring2, spring3
    add_vector(b, p, plus(plus(scaled(g0, f), f1), plus(f2, f3)))
    add_vector(b, p + 1, minus(scaled(g1, f), f1))
    add_vector(b, p + 2, minus(scaled(g2, f), f2))
    add_vector(b, p + 3, minus(scaled(g3, f), f3))
    K0 = sym3.times(g0, K)
    add_diagonal(A, p, *sym3.plus(sym3.plus(sym3.times(g0, K0), K1), sym3.plus(K2, K3)))
    add_coupling(A, p, 1, sym3.minus(sym3.times(g1, K0), K1))
    add_coupling(A, p, 2, sym3.minus(sym3.times(g2, K0), K2))
    add_coupling(A, p, 3, sym3.minus(sym3.times(g3, K0), K3))
    K0 = sym3.times(g1, K)
    add_diagonal(A, p + 1, *sym3.plus(sym3.times(g1, K0), K1))
    add_coupling(A, p + 1, 1, sym3.times(g2, K0))
    add_coupling(A, p + 1, 2, sym3.times(g3, K0))
    K0 = sym3.times(g2, K)
    add_diagonal(A, p + 2, *sym3.plus(sym3.times(g2, K0), K2))
    add_coupling(A, p + 2, 1, sym3.times(g3, K0))
    add_diagonal(A, p + 3, *sym3.plus(sym3.times(g3 * g3, K), K3))
