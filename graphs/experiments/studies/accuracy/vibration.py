"""Bending modes of a straight strand: eigenvalues of the stiffness compared with Euler-Bernoulli theory."""

from collections.abc import Sequence

import numpy as np

from hairpipe.graphs.experiments.studies.accuracy.sample import Sample
from hairpipe.graphs.experiments.studies.accuracy.specimen import Specimen, stiffness, straight_specimen
from hairpipe.graphs.experiments.studies.accuracy.statics import motions
from hairpipe.graphs.experiments.studies.theory.beam_modes import bending_frequencies, bending_shape
from hairpipe.values import Table
from hairpipe.values.table import table_of_rows

COLUMNS = (
    "strand",
    "segments",
    "mode",
    "theory [Hz]",
    "lower [Hz]",
    "upper [Hz]",
    "lower error [%]",
    "upper error [%]",
)


def vibration_table(sample: Sample, segments: Sequence[int], modes: int) -> Table:
    """Tabulate the two frequencies of each bending mode: a network has two stiffnesses, a round rod has one."""
    theory = bending_frequencies(modes, sample.length, sample.material.bending, sample.material.line_density)
    rows = []
    for count in segments:
        pairs = frequencies(straight_specimen(sample, count), modes)
        for mode, (wanted, pair) in enumerate(zip(theory, pairs, strict=True), start=1):
            rows.append((sample.name(count), count, mode, wanted, *pair, *(100 * (pair / wanted - 1))))
    return table_of_rows(COLUMNS, rows)


def frequencies(specimen: Specimen, modes: int) -> np.ndarray:
    """Return the two frequencies of the eigenvectors most like each bending mode [Hz], ascending, (modes, 2)."""
    from scipy.linalg import eigh

    free = motions(specimen)
    root = np.sqrt(free.T @ specimen.weight(np.ones(3)).reshape(-1))
    heavy = root > 0.0
    root = root[heavy]
    matrix = condensed(free.T @ stiffness(specimen, specimen.rest) @ free, heavy)
    squares, vectors = eigh(matrix / np.outer(root, root))
    along = specimen.rest.x[specimen.shape.clamped : specimen.tip + 1, 2]
    heights = np.clip(along / along[-1], 0, 1)
    vectors = (vectors * root[:, None]).reshape(len(heights), 3, -1)
    found = []
    for mode in range(modes):
        likeness = np.sum(np.einsum("p,pce->ce", bending_shape(mode, heights), vectors[:, :2]) ** 2, axis=0)
        found.append(np.sort(squares[np.argsort(likeness)[-2:]]))
    return np.sqrt(np.maximum(found, 0)) / (2 * np.pi)


def condensed(matrix: np.ndarray, kept: np.ndarray) -> np.ndarray:
    """Return what a stiffness is to the unknowns kept, (m,) bool, where all others balance: angles have no inertia."""
    others = matrix[np.ix_(~kept, kept)]
    return matrix[np.ix_(kept, kept)] - others.T @ np.linalg.solve(matrix[np.ix_(~kept, ~kept)], others)
