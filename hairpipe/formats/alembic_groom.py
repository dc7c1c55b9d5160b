"""Grooms in Alembic (.abc) for other programs, with the attributes of Unreal's groom specification, version 1.5.

Unreal takes points as they are, as centimetres in its left-handed axes, and reads the version from the topmost object
(AlembicHairTranslator.cpp). Houdini shows all attributes under their names, and deforms hair with `rest`. Blender reads
points and widths, and turns the vertical axis itself.

Source: Alembic for Grooms Specification, dev.epicgames.com
"""

import errno
import os
import shutil
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from hairpipe import __version__
from hairpipe.errors import BadInput
from hairpipe.formats.alembic_curves import KNOWN
from hairpipe.formats.alembic_meshes import import_alembic
from hairpipe.formats.groom_shot import GroomShot
from hairpipe.values.groom import DIAMETERS, labels_of

VERSION = (1, 5)
GUIDED = ("groom_closest_guides", "groom_guide_weights")
"""Parameters of the guides of each strand, and of their weights; Unreal reads them, we do not."""
LEFT_HANDED_Z_UP = np.array([[1.0, 0, 0], [0, 0, 1], [0, 1, 0]])


class Target(NamedTuple):
    """What a program reads.

    metres  unit of its lengths [m]
    axes    its coordinates from ours, (3, 3)
    rest    whether it reads the rest shape
    apart   whether guides are an object of their own
    """

    metres: float
    axes: np.ndarray
    rest: bool
    apart: bool

    def placed(self, vectors: np.ndarray) -> np.ndarray:
        """Return points or velocities, (p, 3), in the units and axes of the program."""
        return vectors @ self.axes.T / self.metres


TARGETS = {
    "unreal": Target(0.01, LEFT_HANDED_Z_UP, rest=False, apart=False),
    "houdini": Target(1.0, np.eye(3), rest=True, apart=True),
    "blender": Target(1.0, np.eye(3), rest=False, apart=True),
}


def write_alembic(path: Path, shot: GroomShot, name: str) -> None:
    """Write hair and guides for a program, with samples at the true times of frames."""
    library = import_alembic(path)
    target = TARGETS[name]
    if shutil.disk_usage(path.parent).free < size_of(shot):  # the library ends the process where the disk is full
        raise OSError(errno.ENOSPC, os.strerror(errno.ENOSPC), str(path))
    frames = [] if shot.hair is None else list(shot.hair)
    try:
        archive = library.Abc.OArchive(str(path))
        times = archive.addTimeSampling(sampling_of(library, np.array(frames or [0]) / shot.fps, shot.fps))
        top = library.AbcGeom.OXform(archive.getTop(), "groom")
        state_version(library, top)
        maps = shot.maps({*KNOWN, *(GUIDED if shot.closest else ())})
        pieces = shot.pieces(target.apart).items()
        written = [Curves(library, top, piece, shot, maps, target, times) for piece in pieces]
        for curves in written:
            if not frames:
                curves.add(shot.groom.points, None, shot.widths(None))
        for frame in frames:
            hair = shot.at(frame)
            widths = shot.widths(hair)
            for curves in written:
                curves.add(hair.points, hair.velocities, widths)
    except RuntimeError as error:
        what = f"the Alembic file was not written: {str(error).splitlines()[0][:160]}"
        raise BadInput(what, where=path, right="a folder with space, where files can be made") from None


def size_of(shot: GroomShot) -> int:
    """Return an upper bound of the bytes of a file: points, velocities and widths, and what does not move."""
    points, strands, maps = len(shot.groom.points), len(shot.groom.ids), len(shot.groom.maps)
    moving = 28 * points * (1 + len(shot.hair or ()))
    return 100_000 + moving + 32 * points + (256 + 4 * maps) * strands + 1_000 * maps


def sampling_of(library: Any, seconds: np.ndarray, fps: float) -> Any:
    """Return the times of samples: uniform where frames follow each other at equal distances, since Unreal asks so."""
    core = library.AbcCoreAbstract
    steps = np.diff(seconds)
    if not len(steps) or np.ptp(steps) * fps < 1e-6:
        return core.TimeSampling(steps[0] if len(steps) else 1 / fps, seconds[0])
    times = core.TimeVector()
    times.extend(seconds.tolist())
    return core.TimeSampling(core.TimeSamplingType(core.AcyclicFlag.kAcyclic), times)


def state_version(library: Any, top: Any) -> None:
    properties = top.getSchema().getUserProperties()
    for name, number in zip(("groom_version_major", "groom_version_minor"), VERSION, strict=True):
        library.Abc.OInt16Property(properties, name).setValue(number)
    library.Abc.OStringProperty(properties, "groom_tool").setValue(f"hairpipe {__version__}")


class Curves:
    """Curves of one object in a file that is open for writing."""

    def __init__(
        self,
        library: Any,
        top: Any,
        piece: tuple[str, np.ndarray],
        shot: GroomShot,
        maps: dict[str, np.ndarray],
        target: Target,
        times: int,
    ) -> None:
        name, self.strands = piece
        self.library, self.target = library, target
        self.rows = shot.rows(self.strands)
        space = library.AbcGeom.OXform(top, name)  # Blender names objects by the transforms above them
        self.schema = library.AbcGeom.OCurves(space, name, times).getSchema()
        self.counts = array("IntArray", np.diff(shot.groom.offsets)[self.strands])
        self._author(shot, maps)

    def add(self, points: np.ndarray, velocities: np.ndarray | None, widths: np.ndarray) -> None:
        """Write points [m] and velocities [m/s], (P, 3) each, and widths, (P,) [m], at the next sample."""
        geometry = self.library.AbcGeom
        sample = geometry.OCurvesSchemaSample(self._vectors(points), self.counts, geometry.CurveType.kLinear)
        sample.setBasis(geometry.BasisType.kNoBasis)  # by default Bezier, which Blender draws also for linear curves
        wide = array("FloatArray", widths[self.rows] / self.target.metres)
        sample.setWidths(geometry.OFloatGeomParamSample(wide, vertex(self.library)))
        if velocities is not None:
            sample.setVelocities(self._vectors(velocities))
        self.schema.set(sample)

    def _vectors(self, vectors: np.ndarray) -> Any:
        return array("V3fArray", self.target.placed(vectors[self.rows]))

    def _author(self, shot: GroomShot, maps: dict[str, np.ndarray]) -> None:
        uniform = self.library.AbcGeom.GeometryScope.kUniformScope
        groom, strands = shot.groom, self.strands
        numbers = {"groom_id": groom.ids, "groom_guide": groom.guides, "groom_group_id": groom.groups}
        for name, values in numbers.items():
            if values is not None:
                self._parameter("Int32", name, array("IntArray", values[strands]), uniform)
        for name, values in maps.items():
            self._parameter("Float", name, array("FloatArray", values[strands]), uniform)
        if groom.groups is not None and groom.group_names:
            names = labels_of(groom.groups, groom.group_names)[strands]
            self._parameter("String", "groom_group_name", texts(names.tolist()), uniform)
        self._parameter("V2f", "groom_root_uv", array("V2fArray", groom.root_uv[strands]), uniform)
        if shot.closest is not None:
            closest, weights = (values[strands] for values in shot.closest)
            self._parameter("V3i", GUIDED[0], array("V3iArray", closest), uniform)
            self._parameter("V3f", GUIDED[1], array("V3fArray", weights), uniform)
        if groom.colours is not None:
            self._parameter("V3f", "groom_color", array("V3fArray", groom.colours[self.rows]), vertex(self.library))
        if shot.hairs is not None:
            diameters = array("FloatArray", shot.diameters(shot.first())[self.rows] / self.target.metres)
            self._parameter("Float", DIAMETERS, diameters, vertex(self.library))
        if self.target.rest:
            self._parameter("V3f", "rest", self._vectors(groom.points), vertex(self.library))

    def _parameter(self, kind: str, name: str, values: Any, scope: Any) -> None:
        geometry = self.library.AbcGeom
        made = getattr(geometry, f"O{kind}GeomParam")(self.schema.getArbGeomParams(), name, False, scope, 1)
        made.set(getattr(geometry, f"O{kind}GeomParamSample")(values, scope))


def vertex(library: Any) -> Any:
    return library.AbcGeom.GeometryScope.kVertexScope


def array(kind: str, values: np.ndarray) -> Any:
    import imath

    made = getattr(imath, kind)(len(values))
    np.asarray(made)[:] = values
    return made


def texts(values: list[str]) -> Any:
    import imath

    made = imath.StringArray(len(values))
    for index, value in enumerate(values):
        made[index] = value
    return made
