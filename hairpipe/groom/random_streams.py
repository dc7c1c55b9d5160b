"""Random numbers that depend on nothing but a seed and what they are for."""

import hashlib

import numpy as np


def stream(seed: int, purpose: str) -> np.random.Generator:
    """Return the generator of one purpose: adding a purpose never changes the numbers of another."""
    digest = hashlib.sha256(f"hairpipe.groom/{seed}/{purpose}".encode()).digest()
    return np.random.Generator(np.random.Philox(key=int.from_bytes(digest[:16], "little")))
