"""Normals that hair carries, compared with the shell of the hair as it is at the frame."""

from collections.abc import Mapping

import numpy as np

from hairpipe.errors import BadInput
from hairpipe.groom.interpolating import probe_shell
from hairpipe.values import LevelSet, Normals, Strands, Table
from hairpipe.values.table import table_of_rows

COLUMNS = (
    "frame",
    "carried, median [deg]",
    "carried, mean [deg]",
    "terminator [deg]",
    "behind, normals [1]",
    "behind, Kajiya [1]",
    "gradient [1]",
)
NEAR = 3.0
"""Voxels from the shell within which hair is its surface, and its gradient is looked at."""
BELT, BEHIND = 0.5, -0.5
"""Cosines to a lamp: hair's terminator is looked for where the shell's is less than that; and it is dark below."""


def shell_table(hair: Mapping[int, Strands], normals: Mapping[int, Normals], shell: Mapping[int, LevelSet]) -> Table:
    """Return a row a frame, of the points of hair that are near the shell.

    carried     angle between the normal that hair carries and that of the shell
    terminator  angle between those of shell and hair, on average over lamps along the six axes: with n the normal of
                the shell and N that of hair, where N.l, fitted as a line over n.l, is 0
    behind      diffuse light, over the brightest, where the shell is 30 degrees and more behind its terminator: by
                normals, max(0, N.l), and after Kajiya and Kay, sin(t,l)
    gradient    mean of ||grad S| - 1| there, by central differences

    Raises BadInput where the normals are not those of the hair, or none of it is near the shell.
    """
    return table_of_rows(COLUMNS, [(f, *_measured(hair[f], normals[f].vectors, shell[f])) for f in hair])


def _measured(hair: Strands, normals: np.ndarray, shell: LevelSet) -> tuple[float, ...]:
    if len(normals) != len(hair.points):
        raise BadInput(f"{len(normals)} normals of {len(hair.points)} points", where="in.normals", right="of this hair")
    found = probe_shell(hair.points.astype(float), shell)
    near = (np.abs(found.distance) < NEAR * shell.voxel) & normals.any(axis=1)
    if not near.any():
        raise BadInput("no hair is near the shell", where="in.shell", right="the shell of this hair")
    true = found.normal[near]
    rotated = normals[near].astype(float)
    along = tangents_of(hair)[near]
    angles = np.degrees(np.arccos(np.clip(np.einsum("pi,pi->p", true, rotated), -1.0, 1.0)))
    lamps = np.concatenate([np.eye(3), -np.eye(3)])
    by_shell, by_hair = true @ lamps.T, rotated @ lamps.T
    apart = np.mean([terminator(*both) for both in zip(by_shell.T, by_hair.T, strict=True)])
    dark = by_shell < BEHIND
    kajiya = np.sqrt(np.maximum(0.0, 1.0 - (along @ lamps.T) ** 2))
    behind = [np.mean(light[dark]) for light in (np.maximum(0.0, by_hair), kajiya)]
    return float(np.median(angles)), float(angles.mean()), float(apart), *behind, gradient_error(shell)


def terminator(by_shell: np.ndarray, by_hair: np.ndarray) -> float:
    """Return the angle at which hair goes dark, from where the shell does [deg]; pure.

    by_shell, by_hair  cosines between a lamp and the normals of the shell and of hair, (n,)
    """
    belt = np.abs(by_shell) < BELT
    slope, shift = np.polyfit(by_shell[belt], by_hair[belt], 1)
    return float(np.degrees(np.arcsin(min(abs(shift) / max(abs(slope), 1e-9), 1.0))))


def tangents_of(hair: Strands) -> np.ndarray:
    """Return the unit directions of the segments after the points, at tips of that before, (P, 3); pure."""
    ways = np.diff(hair.points, axis=0, append=hair.points[-1:])
    tips = hair.offsets[1:] - 1
    ways[tips] = ways[tips - 1]
    return ways / np.maximum(np.linalg.norm(ways, axis=1, keepdims=True), 1e-300)


def gradient_error(shell: LevelSet) -> float:
    """Return the mean of ||grad S| - 1| at the samples near the surface; pure."""
    inner = (slice(None), *[slice(1, -1)] * 3)
    slopes = np.gradient(shell.distance.astype(float), shell.voxel, axis=(1, 2, 3))
    sizes = np.sqrt(sum(slope[inner] ** 2 for slope in slopes))
    return float(np.abs(sizes - 1.0)[np.abs(shell.distance[inner]) < NEAR * shell.voxel].mean())
