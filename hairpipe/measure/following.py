"""Errors of hair that follows guides, above the part that is chance, and the fewest guides that keep a tolerance.

With e_s^2 the mean square of the distance of a strand from that of a full simulation over points and frames, and d_s^2
that of two members of an ensemble of the full simulation, whose difference is chance, the error above the floor is
sqrt(max(e_s^2 - d_s^2 / 2, 0)): d^2 / 2 estimates the variance of one member, which no guide can predict.
"""

from collections.abc import Callable, Iterable, Mapping, Sequence
from functools import partial
from typing import Literal, NamedTuple

import numpy as np

from hairpipe.errors import BadInput
from hairpipe.groom.guide_choice import Choice, Roots, farthest_roots, fit_guidance, mean_squares, record_motions
from hairpipe.groom.interpolating import interpolated
from hairpipe.groom.key_weights import weigh_keys
from hairpipe.values import Groom, Guidance, Strands, Table
from hairpipe.values.strand_arrays import take
from hairpipe.values.table import table_of_rows

BOUND = 0.95
"""Share of the strands whose errors are within the bound."""
FEWEST, HALVINGS = 8, 5
"""Number of guides that is tried first, and of halvings of the interval of numbers."""
COLUMNS = (
    *("frames", "strands", "rms [m]", "95 % [m]", "largest [m]", "floor [m]"),
    *("rms above floor [m]", "95 % above floor [m]", "largest above floor [m]"),
)
"""Columns of errors: root mean square, percentile and maximum over the strands."""


class Following(NamedTuple):
    """Errors of strands that follow guides over frames; those of the guides are among them.

    squares  mean squares of distances from the full simulation over points and frames [m^2], (S,)
    floor    the part that is chance [m^2], (S,)
    """

    squares: np.ndarray
    floor: np.ndarray

    @property
    def bound(self) -> float:
        """Return the 95th percentile of the errors above the floor [m]."""
        return float(np.quantile(self._above, BOUND))

    @property
    def _above(self) -> np.ndarray:
        return np.sqrt(np.maximum(self.squares - self.floor, 0.0))

    def values(self) -> list[float]:
        """List the values of `COLUMNS` from the number of strands on."""
        errors = np.sqrt(self.squares)
        means = [np.mean(self.squares), np.mean(self.floor)]
        raw = [float(np.sqrt(means[0])), float(np.quantile(errors, BOUND)), float(errors.max())]
        above = [float(np.sqrt(max(means[0] - means[1], 0.0))), self.bound, float(self._above.max())]
        return [len(errors), *raw, float(np.sqrt(means[1])), *above]


def measure_following(
    frames: Iterable[tuple[Strands, Strands, Sequence[Strands]]],
) -> Following:
    """Measure hair that follows guides against that of a full simulation, with its twins, at frames; pure.

    Twins are other members of the ensemble of the full simulation; without any the floor is 0. Raises BadInput without
    frames, or for other strands.
    """
    squares, floors = [], []
    for shown, hair, twins in frames:
        if any(not np.array_equal(hair.offsets, other.offsets) for other in (shown, *twins)):
            raise BadInput("the strands are not those of the full simulation", right="the same groom")
        squares.append(mean_squares(shown.points - hair.points, hair.offsets))
        away = [0.5 * mean_squares(twin.points - hair.points, hair.offsets) for twin in twins]
        floors.append(np.mean(away, axis=0) if away else np.zeros(len(squares[-1])))
    if not squares:
        raise BadInput("there are no frames to compare", right="at least one frame")
    return Following(np.mean(squares, axis=0), np.mean(floors, axis=0))


def following_table(
    hair: Mapping[int, Strands], truth: Mapping[int, Strands], twins: Sequence[Mapping[int, Strands]], skip: int
) -> Table:
    """Return a row of errors of hair, at all frames but the first ones; raises what `measure_following` raises."""
    frames = [*hair][skip:]
    found = measure_following((hair[frame], truth[frame], [twin[frame] for twin in twins]) for frame in frames)
    return table_of_rows(COLUMNS, [["all", *found.values()]])


class Sample(NamedTuple):
    """A full simulation at a frame: hair, motions of its roots, its twins, and hair of keys simulated alone."""

    hair: Strands
    roots: Roots
    twins: Sequence[Strands]
    key_hair: Strands | None


class Found(NamedTuple):
    """Guides, what all strands follow, and a table of the errors."""

    keys: Groom
    guidance: Guidance
    errors: Table


class Guiding:
    """Guides of a groom, chosen and fitted at some frames of a full simulation, and measured at others between these.

    samples  largest number of frames of either kind
    Raises BadInput for fewer than two frames.
    """

    def __init__(self, groom: Groom, read: Callable[[int], Sample], numbers: Sequence[int], samples: int) -> None:
        if len(numbers) < 2:
            raise BadInput("guides are chosen from one frame", right="two frames or more")
        count = min(2 * samples, len(numbers) - 1)
        places = np.linspace(0, len(numbers) - 1, count + 1).round().astype(int)
        self._groom = groom
        self.fitted = [read(numbers[place]) for place in places[:0:-2]]
        self.between = [read(numbers[place]) for place in places[-2:0:-2]]
        self.motions = record_motions(groom, [(sample.hair, sample.roots) for sample in self.fitted])

    def find(self, guides: int | None, tolerance: float | None, by: Literal["motion", "roots"]) -> Found:
        """Choose so many guides, up to all strands, or the fewest of those tried whose bound keeps a tolerance [m].

        Numbers are doubled until the bound is kept, and halved between the last two. BadInput unless one is given.
        """
        total = len(self._groom.ids)
        if (guides is None) == (tolerance is None):
            raise BadInput("guides are chosen by their number or by a tolerance", right="guides or tolerance")
        order = Choice(self._groom, self.motions).guides if by == "motion" else partial(farthest_roots, self._groom)
        if guides is not None:
            return self.fit(take(self._groom, np.sort(order(min(guides, total)))))[0]
        kept = 0
        count = min(FEWEST, total)
        found, bound = self.fit(take(self._groom, np.sort(order(count))))
        while bound > (tolerance or 0.0) and count < total:
            kept = count
            count = min(2 * count, total)
            found, bound = self.fit(take(self._groom, np.sort(order(count))))
        for _ in range(HALVINGS):
            middle = (kept + count) // 2
            if middle <= kept:
                break
            fewer, bound = self.fit(take(self._groom, np.sort(order(middle))))
            if bound <= (tolerance or 0.0):
                found, count = fewer, middle
            else:
                kept = middle
        return found

    def fit(self, keys: Groom) -> tuple[Found, float]:
        """Fit the guidance of keys, and measure it; return the larger bound of both kinds of frames, too [m].

        Raises BadInput for keys without hair: those that are neither strands of the groom nor simulated alone.
        """
        weights = weigh_keys(keys, self._groom, 180.0)
        homes = weights.homes
        if self.fitted[0].key_hair is None and len(np.unique(weights.own[weights.own >= 0])) < len(keys.ids):
            raise BadInput("keys are not strands of the groom", where="in.keys", right="in.key_hair: their hair")

        def hair_of(sample: Sample) -> Strands:
            hair = take(sample.hair, homes) if sample.key_hair is None else sample.key_hair
            if not np.array_equal(hair.offsets, keys.offsets):
                raise BadInput("keys and their hair are not the same strands", where="in.key_hair", right="of in.keys")
            return hair

        now = [(hair_of(s), (s.roots[0][homes], s.roots[1][homes])) for s in self.fitted]
        turns = record_motions(keys, now)
        guidance = fit_guidance(self._groom, self.motions, keys, turns)
        followed = weigh_keys(keys, self._groom, 180.0, guidance)
        kinds = {"fitted": self.fitted, "between": self.between}
        errors = {
            kind: measure_following(
                (interpolated(hair_of(s), keys, self._groom, followed, s.roots), s.hair, s.twins) for s in samples
            )
            for kind, samples in kinds.items()
            if samples
        }
        rows = [[kind, *following.values()] for kind, following in errors.items()]
        bound = max(following.bound for following in errors.values())
        return Found(keys, guidance, table_of_rows(COLUMNS, rows)), bound
