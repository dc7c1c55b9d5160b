"""The values that travel along the edges of a graph: frozen dataclasses of numpy arrays and scalars, nothing else."""

from hairpipe.values.body import (
    BlendShapes,
    Body,
    BodyParts,
    Bound,
    Density,
    DualQuaternions,
    LevelSet,
    Mesh,
    Pose,
    Skeleton,
)
from hairpipe.values.groom import Ends, Groom, Guidance, Normals, Pins, PointValues, Strands
from hairpipe.values.hair import Cloud, Particles
from hairpipe.values.table import Table

__all__ = [
    "BlendShapes",
    "Body",
    "BodyParts",
    "Bound",
    "Cloud",
    "Density",
    "DualQuaternions",
    "Ends",
    "Groom",
    "Guidance",
    "LevelSet",
    "Mesh",
    "Normals",
    "Particles",
    "Pins",
    "PointValues",
    "Pose",
    "Skeleton",
    "Strands",
    "Table",
]
