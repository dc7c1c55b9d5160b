"""Bending modes of a straight strand: eigenvalues of the stiffness compared with Euler-Bernoulli theory."""

from collections.abc import Sequence

import numpy as np

from hairpipe.data import Table
from hairpipe.data.table import table_of_rows
from hairpipe.studies.accuracy.sample import Sample
from hairpipe.studies.accuracy.specimen import Specimen, straight_specimen
from hairpipe.studies.accuracy.statics import motions, stiffness
from hairpipe.studies.theory.beam_modes import bending_frequencies, bending_shape

COLUMNS = ("segments", "mode", "theory [Hz]", "lower [Hz]", "upper [Hz]", "lower error [%]", "upper error [%]")


def vibration_table(sample: Sample, segments: Sequence[int], modes: int) -> Table:
    """Tabulate the two frequencies of each bending mode: the network has two stiffnesses, a round rod has one."""
    theory = bending_frequencies(modes, sample.length, sample.material.bending, sample.material.line_density)
    rows = []
    for count in segments:
        pairs = frequencies(straight_specimen(sample, count), modes)
        for mode, (wanted, pair) in enumerate(zip(theory, pairs, strict=True), start=1):
            rows.append((count, mode, wanted, *pair, *(100 * (pair / wanted - 1))))
    return table_of_rows(COLUMNS, rows)


def frequencies(specimen: Specimen, modes: int) -> np.ndarray:
    """Return the two frequencies of the eigenvectors most like each bending mode [Hz], ascending, (modes, 2)."""
    from scipy.linalg import eigh

    free = motions(specimen)
    root = np.sqrt(np.repeat(specimen.mass, 3))[9:]
    matrix = free.T @ stiffness(specimen, specimen.rest) @ free / np.outer(root, root)
    squares, vectors = eigh(matrix)
    heights = np.clip(specimen.rest[3:, 2] / specimen.rest[-1, 2], 0, 1)
    vectors = (vectors * root[:, None]).reshape(len(heights), 3, -1)
    found = []
    for mode in range(modes):
        likeness = np.sum(np.einsum("p,pce->ce", bending_shape(mode, heights), vectors[:, :2]) ** 2, axis=0)
        found.append(np.sort(squares[np.argsort(likeness)[-2:]]))
    return np.sqrt(np.maximum(found, 0)) / (2 * np.pi)
