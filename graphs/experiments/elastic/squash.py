"""Shapes from which a solid has to find back to its own."""

from dataclasses import replace
from typing import Literal

import numpy as np

from hairpipe.graphs.experiments.elastic.elastic_values import Solid

Shape = Literal["plane", "line", "slanted_line", "mirrored", "scrambled", "scrambled_line", "point"]


def squash(solid: Solid, shape: Shape, seed: int) -> Solid:
    """Move the particles of a solid onto a shape about their middle.

    plane           through the Y axis; line  the X axis; slanted_line  x = y = z; mirrored  in a plane
    scrambled       random places, as far apart as they are at rest; scrambled_line  the same on the X axis
    point           all in the middle
    """
    middle = solid.points.mean(axis=0)
    points = solid.points - middle
    random = np.random.default_rng(seed).normal(size=points.shape) * points.std()
    moved = {
        "plane": points * [1, 1, 0],
        "line": points * [1, 0, 0],
        "slanted_line": points.sum(axis=1)[:, None] * np.ones(3) / 3,
        "mirrored": points * [1, 1, -1],
        "scrambled": random,
        "scrambled_line": random * [1, 0, 0],
        "point": 0 * points,
    }
    return replace(solid, points=middle + moved[shape])
