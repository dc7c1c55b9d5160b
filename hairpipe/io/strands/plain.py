"""Strands of files that state neither unit nor axis, in metres with Y up."""

from typing import Any, Literal

import numpy as np

from hairpipe.data.curves import Curves

Up = Literal["y", "z"]


def plain_curves(points: np.ndarray, counts: np.ndarray, unit: float, up: Up, **more: Any) -> Curves:
    """Return strands with free tips, numbered by their order; pure.

    points  in the unit and with the axis of the file, (p, 3)
    counts  number of points of each strand, (S,)
    unit    unit of the file [m]
    more    other fields of `Curves`; widths and points at rest are as in the file
    """
    total = len(counts)
    if more.get("widths") is not None:
        more["widths"] = unit * np.asarray(more["widths"], np.float64)
    if more.get("rest") is not None:
        more["rest"] = in_metres(more["rest"], unit, up)
    return Curves(
        in_metres(points, unit, up),
        np.concatenate(([0], np.cumsum(counts))).astype(np.int32),
        np.arange(total, dtype=np.int32),
        np.zeros(total, bool),
        np.zeros(total, np.int64),
        **more,
    )


def in_metres(points: np.ndarray, unit: float, up: Up) -> np.ndarray:
    """Return points of a file, (p, 3), in metres with Y up, float64; pure."""
    x, y, z = points.T.astype(np.float64) * unit
    return np.stack((x, y, z) if up == "y" else (x, z, -y), axis=1)
