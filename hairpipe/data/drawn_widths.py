"""Widths of strands in a picture, where each represents many hairs."""

import numpy as np

DIAMETERS = "hairDiameter"
"""Attribute of the diameters at points in files whose widths are those of a picture."""
TAPER = 0.35
"""Part of a strand, at its tip, over which a drawn one narrows to nothing."""


def drawn_widths(diameters: np.ndarray, offsets: np.ndarray, hairs: float) -> np.ndarray:
    """Return the widths with which every strand covers the area of a number of hairs [m], (p,) float32; pure.

    A strand that represents more than one hair narrows to its tip, as the ends of its hairs do.

    diameters  of the strands at their points [m], (p,)
    offsets    strand s owns points offsets[s]:offsets[s+1], (S+1,)
    hairs      number of hairs that a strand represents; up to 1, widths are diameters
    """
    return (diameters * hairs * tapers(offsets) if hairs > 1.0 else diameters).astype(np.float32)


def tapers(offsets: np.ndarray) -> np.ndarray:
    """Return the widths of strands at their points over those at their roots, 0 at tips, (p,) float64; pure.

    offsets  strand s owns points offsets[s]:offsets[s+1], (S+1,)
    """
    counts = np.diff(offsets)
    left = np.repeat(offsets[1:] - 1, counts) - np.arange(offsets[-1])
    return np.sqrt(np.minimum(left / np.repeat(TAPER * (counts - 1), counts), 1.0))
