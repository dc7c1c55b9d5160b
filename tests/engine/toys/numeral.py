"""The values that toy nodes pass on."""

from dataclasses import dataclass

import numpy as np


@dataclass(frozen=True)
class Numeral:
    """A number, and an array that gives it weight."""

    value: float
    load: np.ndarray


@dataclass(frozen=True)
class Sum:
    """State of a running sum."""

    total: float
    history: np.ndarray


@dataclass(frozen=True)
class Bent:
    """A group of settings."""

    strength: float = 1.0
