"""Scalp of a head: a hairline of elevations seen from the point between the ears."""

import re
from dataclasses import dataclass
from typing import Annotated

import numpy as np

from hairpipe.body.roles import Role, find_roles
from hairpipe.errors import BadInput
from hairpipe.units import Degrees, Interval, Metres
from hairpipe.values import Body

Elevation = Annotated[Degrees, Interval(ge=-89.0, le=89.0)]


@dataclass(frozen=True)
class Scalp:
    """Hairline on a body without a scalp map: elevations of the line, seen from between the ears.

    joint     name of the joint of the head; by default the joint with that role, as in mixamorig:Head
    up        vertical offset from the joint to the point between the ear canals
    forward   forward offset from the joint to the point between the ear canals
    at        position of the point between the ear canals, for a body without a skeleton
    front     elevation of the hairline in the middle of the forehead
    temple    elevation of the hairline at its corner above the temple
    sideburn  elevation of the hairline in front of the ear
    ear       elevation of the hairline above the ear
    behind    elevation of the hairline behind the ear
    nape      elevation of the hairline in the middle of the neck
    edge      width over which the map rises from 0 to 1
    """

    joint: str = "head"
    up: Metres = 0.010
    forward: Metres = 0.035
    at: tuple[Metres, Metres, Metres] | None = None
    front: Elevation = 46.0
    temple: Elevation = 44.0
    sideburn: Elevation = 16.0
    ear: Elevation = 28.0
    behind: Elevation = -18.0
    nape: Elevation = -30.0
    edge: Annotated[Degrees, Interval(ge=0.1, le=90.0)] = 12.0


HEAD, CROWN = 0.2, 0.13  # height of a head above the chin, and of its crown above the ear canals [m]
RIGIFY = re.compile(r"(^|\W|_)spine[._]006$")  # name of the head of Blender's Rigify
AZIMUTHS = (0.0, 45.0, 76.0, 98.0, 130.0, 180.0)  # of front, temple, sideburn, ear, behind and nape [deg from +Z]


def between_ears(points: np.ndarray) -> tuple[float, float, float]:
    """Return about where the point between the ear canals is [m] of a bust, or a person, that stands upright; pure.

    points  of its skin, the face towards +Z [m], (n, 3)
    """
    head = points[points[:, 1] > points[:, 1].max() - HEAD]
    middle = 0.5 * (head.min(axis=0) + head.max(axis=0))
    return float(middle[0]), float(points[:, 1].max() - CROWN), float(middle[2])


def paint_scalp(body: Body, rule: Scalp) -> np.ndarray:
    """Return the scalp map of a body by a hairline rule, 0 below and 1 above it, (n,). Pure.

    Raises BadInput where the body has no such joint.
    """
    names = body.skeleton.names
    heads = [k for k, name in enumerate(names) if name == rule.joint]
    if not heads and rule.joint == Scalp.joint:
        heads = find_roles(names).get(Role("head"), []) or [k for k, name in enumerate(names) if RIGIFY.search(name)]
    if not heads:
        right = f"one of {', '.join(names[:12])}"
        raise BadInput(f"the body has no joint {rule.joint!r}", where="scalp.joint", right=right)
    joint = heads[0]
    centre = body.skeleton.rest[joint, :3, 3] + (0.0, rule.up, rule.forward) if rule.at is None else np.array(rule.at)
    moved = np.where(body.joints == joint, body.weights, 0.0).sum(axis=1)
    return height_above(rule, body.mesh.points - centre) * smooth_step(moved, 0.0, 0.25)


def height_above(rule: Scalp, directions: np.ndarray) -> np.ndarray:
    """Return how far directions from between the ears (n, 3) lie above the hairline, 0..1, (n,). Pure."""
    flat = np.hypot(directions[:, 0], directions[:, 2])
    elevation = np.degrees(np.arctan2(directions[:, 1], flat))
    azimuth = np.degrees(np.arctan2(np.abs(directions[:, 0]), directions[:, 2]))
    line = interpolate_hairline(rule, azimuth)
    return smooth_step(elevation, line - 0.5 * rule.edge, line + 0.5 * rule.edge)


def interpolate_hairline(rule: Scalp, azimuth: np.ndarray) -> np.ndarray:
    """Return the elevation of the hairline [deg] at azimuths 0..180 [deg], level between knots where it turns. Pure."""
    heights = np.array([rule.front, rule.temple, rule.sideburn, rule.ear, rule.behind, rule.nape])
    knots = np.array(AZIMUTHS)
    piece = np.clip(np.searchsorted(knots, azimuth, side="right") - 1, 0, len(knots) - 2)
    share = smooth_step(azimuth, knots[piece], knots[piece + 1])
    return heights[piece] + share * (heights[piece + 1] - heights[piece])


def smooth_step(value: np.ndarray, low: np.ndarray | float, high: np.ndarray | float) -> np.ndarray:
    """Return the cubic 3t^2 - 2t^3 that rises from 0 at `low` to 1 at `high`."""
    share = np.clip((value - low) / (high - low), 0.0, 1.0)
    return share * share * (3.0 - 2.0 * share)
