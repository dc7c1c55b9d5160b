"""What a body of springs does over time, as tables."""

from collections.abc import Iterable

import numpy as np

from hairpipe.graphs.experiments.elastic import mesh_geometry
from hairpipe.graphs.experiments.elastic.elastic_values import ElasticState, Shell, Solid
from hairpipe.graphs.experiments.elastic.hinges import hinges
from hairpipe.values import Table
from hairpipe.values.table import table_of_rows

ENERGY = ("kinetic energy [J]", "spring energy [J]", "potential energy [J]", "energy [J]")


def measure_volume(solid: Solid, states: Iterable[ElasticState]) -> Table:
    """Tabulate volume over the rest volume, tetrahedra that are flat or inverted, the worst of them, and energy."""
    rest = mesh_geometry.volumes(solid.points, solid.tetrahedra)
    rows = []
    for state in states:
        volume = mesh_geometry.volumes(state.positions, solid.tetrahedra)
        shape = 100 * volume.sum() / rest.sum(), int(np.sum(volume <= 0)), 100 * np.min(volume / rest)
        rows.append((state.time, *shape, state.positions[:, 1].max(), *state.energy, state.energy.sum()))
    names = ("time [s]", "volume [%]", "inverted", "least volume [%]", "top [m]", *ENERGY)
    return table_of_rows(names, rows)


def measure_angles(shell: Shell, states: Iterable[ElasticState]) -> Table:
    """Tabulate the error of the angles between triangles, where the centre of the points is, and energy."""
    fours = hinges(shell.triangles)
    rest = mesh_geometry.angles(shell.points, fours)
    rows = []
    for state in states:
        wrong = mesh_geometry.angles(state.positions, fours) - rest
        wrong = np.degrees((wrong + np.pi) % (2 * np.pi) - np.pi)
        errors = np.sqrt(np.mean(wrong**2)), np.abs(wrong).max()
        rows.append((state.time, *errors, *state.positions.mean(axis=0), *state.energy, state.energy.sum()))
    names = ("time [s]", "RMS angle error [deg]", "largest angle error [deg]", "x [m]", "y [m]", "z [m]", *ENERGY)
    return table_of_rows(names, rows)
