"""Two cantilevers that cross at a right angle and press on each other."""

import numpy as np

from hairpipe.errors import BadInput
from hairpipe.strands.material import Material
from hairpipe.values import Strands, Table
from hairpipe.values.table import table_of_rows

COLUMNS = ("beam", "arm [m]", "deflection [mm]", "theory [mm]", "deflection error [%]", "force [uN]", "imbalance [%]")


def pressed_table(first: Strands, last: Strands, thickness: float, material: Material) -> Table:
    """Return a row for each of two strands that are straight at first, one along x and, above it, one along z.

    With the arms a, b from the roots to the crossing, and D the depth by which the axes would be too near undeflected,
    beams of the same E I without friction balance at

        P = 3 E I w_a / a^3 = 3 E I w_b / b^3,   w_a + w_b = D   (Euler-Bernoulli).

    deflection  w at the crossing, along y, against the undeflected strand at the same root
    force       P of the deflection
    imbalance   force over that on the other strand, less 1

    thickness  distance kept between the axes [m]

    BadInput unless there are two strands that cross seen along y.
    """
    if len(last.offsets) != 3:
        raise BadInput(f"{len(last.offsets) - 1} strands", where="in.hair", right="two that cross")
    lower, upper = (slice(*last.offsets[k : k + 2]) for k in (0, 1))
    bent = last.points.astype(float)
    straight = first.points.astype(float)
    for mine in (lower, upper):
        straight[mine] += bent[mine][0] - straight[mine][0]
    x, z = straight[upper][0, 0], straight[lower][0, 2]
    ranges = (straight[lower][:, 0], x), (straight[upper][:, 2], z)
    if not all(places.min() < at < places.max() for places, at in ranges):
        raise BadInput("the strands do not cross", where="in.hair", right="one along x, the other above it, along z")
    arms = np.array([x - straight[lower][0, 0], abs(z - straight[upper][0, 2])])
    deflections = np.array(
        [
            height(straight[lower], 0, x) - height(bent[lower], 0, x),
            height(bent[upper], 2, z) - height(straight[upper], 2, z),
        ]
    )
    depth = height(straight[lower], 0, x) + thickness - height(straight[upper], 2, z)
    theory = depth * arms**3 / np.sum(arms**3)
    forces = 3.0 * material.bending * deflections / arms**3
    errors = 100.0 * (deflections / theory - 1.0)
    balance = 100.0 * (forces / forces[::-1] - 1.0)
    columns = zip(arms, 1e3 * deflections, 1e3 * theory, errors, 1e6 * forces, balance, strict=True)
    return table_of_rows(COLUMNS, [(k, *map(float, row)) for k, row in enumerate(columns)])


def height(points: np.ndarray, axis: int, at: float) -> float:
    """Return y of a polyline, (n, 3), at a coordinate along an axis in which it ascends or descends."""
    ascending = points[np.argsort(points[:, axis])]
    return float(np.interp(at, ascending[:, axis], ascending[:, 1]))
