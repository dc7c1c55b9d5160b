"""The values that travel along the edges of a graph: frozen dataclasses of numpy arrays and scalars, nothing else."""

from hairpipe.data.body import BlendShapes, Body, Bound, DualQuaternions, Pose, Skeleton
from hairpipe.data.density import Density
from hairpipe.data.ends import Ends, Pins
from hairpipe.data.groom import Groom, Strands
from hairpipe.data.levelset import LevelSet
from hairpipe.data.mesh import Mesh
from hairpipe.data.particles import Cloud, Particles
from hairpipe.data.parts import BodyParts
from hairpipe.data.point_values import Normals, PointValues
from hairpipe.data.table import Table

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
