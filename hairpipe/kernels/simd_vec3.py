"""Vectors as tuples of three lanes."""

from hairpipe.kernels.compile import inlined
from hairpipe.kernels.simd import load


@inlined
def cross(a, b):
    """a x b."""
    return a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]


@inlined
def dot(a, b):
    """a . b."""
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]


@inlined
def plus(a, b):
    """a + b."""
    return a[0] + b[0], a[1] + b[1], a[2] + b[2]


@inlined
def scaled(s, a):
    """s a."""
    return s * a[0], s * a[1], s * a[2]


@inlined
def minus(a, b):
    """a - b."""
    return a[0] - b[0], a[1] - b[1], a[2] - b[2]


@inlined
def difference(x, p, q):
    """x_q - x_p of an array (rows, 3, W)."""
    return load(x, (q, 0)) - load(x, (p, 0)), load(x, (q, 1)) - load(x, (p, 1)), load(x, (q, 2)) - load(x, (p, 2))
