"""Cylinders, capsules and balls."""

from typing import Annotated, Literal

from hairpipe.engine import node
from hairpipe.units import Gt, Interval, Metres
from hairpipe.values import Mesh

Direction = tuple[float, float, float]
Place = tuple[Metres, Metres, Metres]


@node(frames="once")
def make_cylinder(
    *,
    radius: Annotated[Metres, Gt(0.0)] = 0.05,
    length: Annotated[Metres, Interval(ge=0.0, le=1e3)] = 0.2,
    ends: Literal["flat", "round"] = "flat",
    centre: Place = (0.0, 0.0, 0.0),
    direction: Direction = (0.0, 0.0, 1.0),
    around: Annotated[int, Interval(ge=8, le=10_000)] = 96,
) -> Mesh:
    """Build a closed cylinder, or with round ends a capsule, or without length a ball.

    radius     radius of the cylinder and of its round ends
    length     length of the cylinder without its round ends
    ends       shape of the ends: flat discs or half balls
    centre     centre of the cylinder
    direction  direction of the axis
    around     number of facets around the axis; with 96 the surface error is 0.0005 of the radius
    """
    from hairpipe.body.shapes import build_cylinder

    return build_cylinder(radius, length, ends == "round", around, centre, direction)
