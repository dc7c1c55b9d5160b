"""Pairs that hair takes no notice of: stuck together, or so close in the groom that they belong there.

A set of pairs is a sorted array of keys without duplicates, see `key_of`; the union of two is `np.union1d`.
"""

import numpy as np

from hairpipe.sim.contact.pairs import key_of

REST = 1.5
"""Pairs that the groom has within so many thicknesses are ignored for ever, as in the authors' code."""


def keys_of(segments: np.ndarray) -> np.ndarray:
    """Make a set of pairs, first < second in each, (n, 2) int32; gives (n,) int64."""
    return np.unique(key_of(segments))
