"""Cylinders, capsules and balls."""

from typing import Annotated, Literal

from hairpipe.data import Mesh
from hairpipe.graph import node
from hairpipe.units import Gt, Interval, Metres

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
    """A closed cylinder about an axis; with round ends a capsule, and without length a ball.

    radius     of the cylinder, and of the half balls that are its round ends
    length     between the ends; round ends are added to it
    ends       flat discs or half balls
    centre     of the cylinder
    direction  of its axis
    around     facets around the axis: they leave the true surface by 0.0005 of the radius with 96
    """
    from hairpipe.body.shapes import build_cylinder

    return build_cylinder(radius, length, ends == "round", around, centre, direction)
