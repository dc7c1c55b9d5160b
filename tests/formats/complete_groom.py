"""A groom that has everything which a file of hair can carry."""

import numpy as np

from hairpipe.values import Groom


def complete_groom(strands: int, points: int) -> Groom:
    """Make straight strands of so many points, in two groups, with ids from 5 on."""
    generator = np.random.default_rng(0)
    roots = generator.random((strands, 3)) * 0.1
    along = np.linspace(0, 0.05, points)[None, :, None] * np.array([0.2, 1, 0])
    return Groom(
        (roots[:, None] + along).reshape(-1, 3),
        (points * np.arange(strands + 1)).astype(np.int32),
        np.arange(strands, dtype=np.int32) + 5,
        np.zeros(strands, np.int32),
        np.tile((1.0, 0, 0), (strands, 1)),
        np.tile(np.eye(3, 4), (strands, 1, 1)),
        generator.random((strands, 2)).astype(np.float32),
        widths=np.linspace(1e-4, 2e-4, strands * points),
        groups=(np.arange(strands) * 2 // strands).astype(np.int32),
        group_names=("beard", "fringe"),
        colours=generator.random((strands * points, 3)).astype(np.float32),
        maps={"clump": np.linspace(0.0, 1.0, strands), "groom_frizz": generator.random(strands)},
    )
