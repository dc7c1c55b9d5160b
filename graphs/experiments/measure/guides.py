"""Choices of guides at equal numbers, on the motion of the choice and on another one; files of guides."""

from collections.abc import Iterator, Mapping
from functools import partial
from importlib.util import module_from_spec, spec_from_file_location
from pathlib import Path
from tempfile import TemporaryDirectory
from time import process_time
from typing import NamedTuple

import numpy as np

from hairpipe.groom.guide_choice import Choice, farthest_roots, mean_squares
from hairpipe.groom.interpolating import interpolated
from hairpipe.groom.key_weights import KeyWeights, weigh_keys
from hairpipe.measure.following import BOUND, COLUMNS, Guiding, Sample, measure_following
from hairpipe.solve.boundary import motion_of_roots
from hairpipe.values import Groom, Mesh, Strands, Table
from hairpipe.values.strand_arrays import take
from hairpipe.values.table import table_of_columns, table_of_rows

PARTING = 30.0
"""As `interpolate_hair` has it by default [deg]."""
ON, OTHER = "between", "another"
"""Motions: that of the choice, at frames between the sampled ones, and another one."""


class Motion(NamedTuple):
    """A full simulation of a motion and its twin."""

    hair: Mapping[int, Strands]
    body: Mapping[int, Mesh]
    twin: Mapping[int, Strands]

    def at(self, groom: Groom, frame: int) -> Sample:
        """Return the frame of the simulation."""
        return Sample(self.hair[frame], motion_of_roots(self.body[frame], groom), (self.twin[frame],), None)


def compared(groom: Groom, motions: tuple[Motion, Motion], every: tuple[int, ...], samples: int) -> Table:
    """Return a row for each number of guides, choice, way to follow, and motion; the first motion is that of choice."""
    on, other = motions
    frames = [*on.hair]
    guiding = Guiding(groom, partial(on.at, groom), frames, samples)
    later = [other.at(groom, frame) for frame in [*other.hair][1:]]
    order = Choice(groom, guiding.motions)
    rows = []
    for n in every:
        strands = np.arange(n // 2, len(groom.ids), n)
        number = len(strands)
        choices = {
            "one in n": strands,
            "farthest roots": np.sort(farthest_roots(groom, number)),
            "chosen": order.guides(number),
        }
        for choice, strands in choices.items():
            keys = take(groom, strands)
            fitted = guiding.fit(keys)[0].guidance
            for follows, guidance in (("nearest", None), ("fitted", fitted)):
                weights = weigh_keys(keys, groom, PARTING, guidance)
                for motion, some in ((ON, guiding.between or guiding.fitted), (OTHER, later)):
                    found = measure_following(shown(groom, keys, strands, weights, some))
                    rows.append((choice, n, number, follows, motion, *found.values()))
    names = ("guides are", "strands a guide", "guides", "strands follow", "motion", *COLUMNS[1:])
    return table_of_rows(names, rows)


def shown(
    groom: Groom, keys: Groom, strands: np.ndarray, weights: KeyWeights, samples: list[Sample]
) -> Iterator[tuple[Strands, Strands, tuple[Strands, ...]]]:
    """Return the hair that follows keys, with that of the full simulation and its twins, at frames."""
    for sample in samples:
        hair = interpolated(take(sample.hair, strands), keys, groom, weights, sample.roots)
        yield hair, sample.hair, tuple(sample.twins)


READER = Path(__file__).resolve().parents[3] / "docs/howto/deform_guides.py"
MB = 1e6


def file_table(whole: Path, guides: Path) -> Table:
    """Return sizes of a file of all strands and of one of guides, time of the reader and its error: one row."""
    spec = spec_from_file_location("deform_guides", READER)
    assert spec is not None and spec.loader is not None
    reader = module_from_spec(spec)
    spec.loader.exec_module(reader)
    with TemporaryDirectory() as folder:  # Files of the store have no suffix that names their format.
        named = [Path(folder) / f"{name}.usdc" for name in ("guides", "all")]
        for name, path in zip(named, (guides, whole), strict=True):
            name.symlink_to(path.resolve())
        stages = [reader.Usd.Stage.Open(str(name)) for name in named]
    strands = reader.Strands(stages[0])
    points = reader.UsdGeom.BasisCurves(stages[1].GetDefaultPrim().GetChild("hair")).GetPointsAttr()
    frames = points.GetTimeSamples()
    squares = np.zeros(len(strands.counts))
    seconds = 0.0
    for frame in frames:
        begun = process_time()
        found = strands.at(frame)
        seconds += process_time() - begun
        squares += mean_squares(found - np.array(points.Get(frame), float), np.append(strands.firsts, len(found)))
    errors = np.sqrt(squares / len(frames))
    sizes = [path.stat().st_size / MB for path in (whole, guides)]
    columns = {
        "strands": [len(errors)],
        "guides": [len(strands.guide_counts)],
        "frames": [len(frames)],
        "all strands [MB]": [sizes[0]],
        "guides [MB]": [sizes[1]],
        "a frame of guides [MB]": [strands.guide_counts.sum() * 24 / MB],
        "a frame of all strands [MB]": [strands.counts.sum() * 24 / MB],
        "processor time a frame [s]": [seconds / len(frames)],
        "rms [m]": [np.sqrt(np.mean(errors**2))],
        "95 % [m]": [np.quantile(errors, BOUND)],
        "largest [m]": [errors.max()],
    }
    return table_of_columns(columns)
