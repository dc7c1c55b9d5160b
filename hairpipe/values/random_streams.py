"""Random numbers that depend on nothing but a seed and what they are for."""

import hashlib

import numpy as np

GOLDEN = 0.6180339887498949
"""Its multiples modulo 1 lie evenly: each further one falls into a widest gap."""


def stream(seed: int, purpose: str) -> np.random.Generator:
    """Return the generator of one purpose: adding a purpose never changes the numbers of another."""
    digest = hashlib.sha256(f"hairpipe.groom/{seed}/{purpose}".encode()).digest()
    return np.random.Generator(np.random.Philox(key=int.from_bytes(digest[:16], "little")))


def chances(seed: int, purpose: str, ids: np.ndarray) -> np.ndarray:
    """Return a number in [-1, 1) for every id, (n,): that of a strand does not depend on the other strands.

    Source: Steele, Lea, Flood, Fast Splittable Pseudorandom Number Generators, 2014, the output function of SplitMix64.
    """
    digest = hashlib.sha256(f"hairpipe.groom/{seed}/{purpose}".encode()).digest()
    z = np.uint64(int.from_bytes(digest[:8], "little")) + ids.astype(np.uint64) * np.uint64(0x9E3779B97F4A7C15)
    z = (z ^ (z >> np.uint64(30))) * np.uint64(0xBF58476D1CE4E5B9)
    z = (z ^ (z >> np.uint64(27))) * np.uint64(0x94D049BB133111EB)
    return ((z ^ (z >> np.uint64(31))) >> np.uint64(11)).astype(np.float64) * 2.0**-52 - 1.0
