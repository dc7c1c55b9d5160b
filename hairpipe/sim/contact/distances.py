"""Sixteen distances between segments at once."""

from hairpipe.body.inlined import inlined
from hairpipe.sim.lanes import load_from, maximum, minimum, multiply_add

_TINY = 1e-30


@inlined
def squared_distances(rows, p, d, dd, inverse, start):  # noqa: ANN001, ANN201
    """Return the squared distances [cells^2] of the segment p + s d to the pieces of a grid from `start` on, as lanes.

    rows         of the grid
    dd, inverse  d.d and one over it, or 0; all float32

    As `closest_on_segments`, but s of the lines is (b f - c e) / (a e - b^2). With u the rounding of single precision
    and theta the angle of the two, s is uncertain by du = (28 R / |d| + 14) u / sin^2 theta, R their distance; t and
    then s are the best for what was before, so that the square comes out too large by at most
    a sin^2 theta min(du, 1)^2 or u (28 R |d| + 14 a), whatever the angle.
    """
    qx, qy, qz = load_from(rows, (0, start)), load_from(rows, (1, start)), load_from(rows, (2, start))
    ex, ey, ez = load_from(rows, (3, start)), load_from(rows, (4, start)), load_from(rows, (5, start))
    ee, over = load_from(rows, (6, start)), load_from(rows, (7, start))
    rx, ry, rz = p[0] - qx, p[1] - qy, p[2] - qz
    de = multiply_add(d[0], ex, multiply_add(d[1], ey, d[2] * ez))
    dr = multiply_add(d[0], rx, multiply_add(d[1], ry, d[2] * rz))
    er = multiply_add(ex, rx, multiply_add(ey, ry, ez * rz))
    area = maximum(multiply_add(dd, ee, -(de * de)), _TINY)
    s = minimum(maximum((de * er - dr * ee) / area, 0.0), 1.0)
    t = minimum(maximum(multiply_add(de, s, er) * over, 0.0), 1.0)
    s = minimum(maximum(multiply_add(de, t, -dr) * inverse, 0.0), 1.0)
    gx = multiply_add(s, d[0], multiply_add(-t, ex, rx))
    gy = multiply_add(s, d[1], multiply_add(-t, ey, ry))
    gz = multiply_add(s, d[2], multiply_add(-t, ez, rz))
    return multiply_add(gx, gx, multiply_add(gy, gy, gz * gz))


@inlined
def fastest_squared(drift, u, v, start):  # noqa: ANN001, ANN201
    """Return the largest squared displacement of an end relative to an end of pieces from `start` on, as lanes.

    drift  displacements of both ends of the pieces, (6, E + LANES) float32
    u, v   of the ends of this segment, float32
    """
    ax, ay, az = load_from(drift, (0, start)), load_from(drift, (1, start)), load_from(drift, (2, start))
    bx, by, bz = load_from(drift, (3, start)), load_from(drift, (4, start)), load_from(drift, (5, start))
    first = maximum(_squared(u[0] - ax, u[1] - ay, u[2] - az), _squared(u[0] - bx, u[1] - by, u[2] - bz))
    second = maximum(_squared(v[0] - ax, v[1] - ay, v[2] - az), _squared(v[0] - bx, v[1] - by, v[2] - bz))
    return maximum(first, second)


@inlined
def _squared(x, y, z):  # noqa: ANN001, ANN202
    return multiply_add(x, x, multiply_add(y, y, z * z))
