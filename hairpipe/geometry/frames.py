"""Material frames of a rod: transported from the root to the tip over its vertices, and rotated there by their twist.

A director m1 normal to the tangent te is transported by the smallest rotation to tf, and then rotated about tf by psi:

    m' = m1 - (tf . m1) / (1 + te . tf) (te + tf),   m1f = cos psi m' + sin psi tf x m'

So the twists of vertices define the frames of a rod: they do not drift with any change of positions, and a rotated
scene has the same twists. Twist has no inertia of its own: each step finds its equilibrium.
"""

from hairpipe.geometry.compile import inlined
from hairpipe.geometry.simd import any_lane, difference, load, maximum, minimum, select, sqrt, store
from hairpipe.geometry.vec3 import cross, dot, minus, plus, scaled

GHOST = 1
"""Row of x_-1; the first vertex is in the row after it."""
TENSION, TWIST, DIRECTOR, BEFORE = 0, 1, 2, 5
"""Indices of the tension of an edge, the twist of a vertex, the director of an edge, and the twist at the start of the
last stage, in the results of solves."""
SPAN = 2
"""Place of the duration of the last stage in the row of q [s]; 0: none."""
BENDING, TWISTING = 4, 5
"""Places of the two stiffnesses of a vertex in what a rod has at rest."""
MOST = 6.2
"""Twist of a vertex beyond which its frame turns no further [rad]."""
FOLDED = 0.02
"""1 + te . tf below which a vertex is folded, beyond 168 degrees: its inverse, which has no bound, grows no further."""
_SMALLEST = 1e-30


@inlined
def unit_of(a):
    """Unit vector of lanes, and 1 / its length."""
    inverse = 1.0 / sqrt(maximum(dot(a, a), _SMALLEST))
    return scaled(inverse, a), inverse


@inlined
def across(q, t):
    """Unit director that points to q, across a unit tangent."""
    return unit_of(minus(q, scaled(dot(q, t), t)))[0]


@inlined
def transport(m, te, tf):
    """Transport a vector normal to te to tf without twist; at a fold to the nearest unit vector normal to tf."""
    chi = 1.0 + dot(te, tf)
    over = minus(m, scaled(dot(tf, m) / maximum(chi, FOLDED), plus(te, tf)))
    folded = chi < FOLDED  # There the denominator is clamped, and the result no unit vector across tf any more.
    if any_lane(folded):
        unit = across(over, tf)
        over = select(folded, unit[0], over[0]), select(folded, unit[1], over[1]), select(folded, unit[2], over[2])
    return over


@inlined
def turned(m, t, sine, cosine):
    """Turn a vector across t about it."""
    return plus(scaled(cosine, m), scaled(sine, cross(t, m)))


@inlined
def sine_cosine(psi):
    """Sine and cosine of lanes, to 1e-13 up to `MOST`: by their series at a quarter of the angle, doubled twice."""
    x = 0.25 * maximum(minimum(psi, MOST), -MOST)  # Series at a quarter of the angle: no calls, lanes stay vectors.
    y = x * x
    s = 1.0 - y * (1.0 / 156.0) * (1.0 - y * (1.0 / 210.0))
    s = x * (
        1.0
        - y
        * (1.0 / 6.0)
        * (1.0 - y * 0.05 * (1.0 - y * (1.0 / 42.0) * (1.0 - y * (1.0 / 72.0) * (1.0 - y * (1.0 / 110.0) * s))))
    )
    c = 1.0 - y * (1.0 / 182.0) * (1.0 - y * (1.0 / 240.0))
    c = 1.0 - y * 0.5 * (
        1.0
        - y
        * (1.0 / 12.0)
        * (1.0 - y * (1.0 / 30.0) * (1.0 - y * (1.0 / 56.0) * (1.0 - y * (1.0 / 90.0) * (1.0 - y * (1.0 / 132.0) * c))))
    )
    for _ in range(2):
        s, c = 2.0 * s * c, c * c - s * s
    return s, c


@inlined
def director_of(x, T, p, t):
    """Director of the edge from row p, whose unit tangent is t: of the buried one as q shows it, else as found."""
    if p == GHOST:
        return across(difference(x, GHOST, 0), t)
    return load(T, (p, DIRECTOR)), load(T, (p, DIRECTOR + 1)), load(T, (p, DIRECTOR + 2))


@inlined
def frame_at(x, T, p):
    """Find the director of the edge after row p + 1 from that of the edge before it, and store it in T.

    Returns both unit tangents, both 1 / lengths and both directors.
    """
    te, ie = unit_of(difference(x, p, p + 1))
    tf, jf = unit_of(difference(x, p + 1, p + 2))
    m1e = director_of(x, T, p, te)
    sine, cosine = sine_cosine(load(T, (p + 1, TWIST)))
    m1f = turned(transport(m1e, te, tf), tf, sine, cosine)
    for c in range(3):
        store(T, (p + 1, DIRECTOR + c), m1f[c])
    return (te, tf), (ie, jf), (m1e, m1f)
