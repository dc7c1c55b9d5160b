"""Symmetric 3 x 3 matrices as tuples of six lanes: xx, xy, xz, yy, yz, zz."""

from hairpipe.geometry.compile import inlined


@inlined
def outer(s, a):
    """s a a^T."""
    x, y, z = s * a[0], s * a[1], s * a[2]
    return x * a[0], x * a[1], x * a[2], y * a[1], y * a[2], z * a[2]


@inlined
def times(s, A):
    """s A."""
    return s * A[0], s * A[1], s * A[2], s * A[3], s * A[4], s * A[5]


@inlined
def plus(A, B):
    """A + B."""
    return A[0] + B[0], A[1] + B[1], A[2] + B[2], A[3] + B[3], A[4] + B[4], A[5] + B[5]


@inlined
def minus(A, B):
    """A - B."""
    return A[0] - B[0], A[1] - B[1], A[2] - B[2], A[3] - B[3], A[4] - B[4], A[5] - B[5]
