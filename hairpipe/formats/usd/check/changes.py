"""Differences of a shot from an earlier one: settings, frames, strands, and their roots, lengths, motion and bounds.

Strands are compared by their ids, and both shots in metres with Y up.
"""

import json
from collections.abc import Iterator
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path

import numpy as np
from pxr import Usd

from hairpipe.formats.usd.check.causes import SHOT, Lineage, is_file, lineage_of, socket_of
from hairpipe.formats.usd.check.scene import Cause, Finding, Scene, Snapshot, Track, find_scene
from hairpipe.formats.usd.curves import IDS
from hairpipe.formats.usd.stage import open_stage, usd_faults

MOVED = 5e-6  # beyond the rounding of single precision at a few metres [m]
RATIO = 1e-3  # difference of lengths and widths that is reported
FACTS = ("startTimeCode", "endTimeCode", "timeCodesPerSecond", "metersPerUnit", "upAxis")
SIDES = np.array(["+X", "-X", "top", "bottom", "+Z", "-Z"])
MILLIMETRES = 1e3
OTHERS = 0.05  # of the size of the scalp: median way of the roots from which ids name other strands
EXPORTED = {"widths": ("hairs",)}
"""Settings of the export on which a difference depends, by its name."""
LISTED = 4  # settings named as the cause of a difference


def compare(path: Path, since: Path) -> list[Finding]:
    """Return what differs in a shot from an earlier one, of severity `change`; BadInput where a file cannot be read."""
    with usd_faults(since):
        before = open_stage(since)
    with usd_faults(path):
        now = open_stage(path)
        changed = _changed_settings(lineage_of(before), lineage_of(now))
        return [*_settings(before, now, changed), *_facts(before, now), *_shapes(before, now, changed)]


Settings = dict[str, tuple[object, object]]
"""Values before and now of the settings that differ, by full name."""


def _changed_settings(before: Lineage | None, now: Lineage | None) -> Settings:
    found: Settings = {}
    if before is None or now is None:
        return found
    for name in dict.fromkeys((*before.nodes, *now.nodes, SHOT)):
        sides = [
            side.settings(name) | ({} if name == SHOT else _wiring(side, name)) if name in (*side.nodes, SHOT) else {}
            for side in (before, now)
        ]
        for setting in dict.fromkeys((*sides[0], *sides[1])):
            old, new = (side.get(setting) for side in sides)
            if old != new:
                found[setting] = old, new
    return found


def _wiring(lineage: Lineage, name: str) -> dict[str, object]:
    node = lineage.nodes[name]
    return {f"{name}.type": node["type"]} | {f"{name}.in.{socket}": source for socket, source in node["in"].items()}


def _settings(before: Usd.Stage, now: Usd.Stage, changed: Settings) -> Iterator[Finding]:
    sides = lineage_of(before), lineage_of(now)
    old, new = sides
    if old is None or new is None:
        lacking = " and ".join(word for word, side in zip(("the earlier", "this"), sides, strict=True) if side is None)
        yield _change("settings", "/", f"unknown: {lacking} file does not state its graph")
        return
    if old.version != new.version:
        yield _change("version", "/", f"hairpipe {old.version} -> {new.version}")
    for name, (was, value) in changed.items():
        yield _change("settings", "/", f"{name} {_text(was)} -> {_text(value)}")
    if not changed:
        what = "the settings are the same: only code, libraries or frames of the run can differ"
        yield _change("settings", "/", what)


def _text(value: object) -> str:
    return "absent" if value is None else f"bytes {value['file'][:8]}" if is_file(value) else json.dumps(value)  # type: ignore[index]


def _facts(before: Usd.Stage, now: Usd.Stage) -> Iterator[Finding]:
    for name in FACTS:
        was, value = (stage.GetMetadata(name) for stage in (before, now))
        if was != value:
            yield _change("stage", "/", f"{name} {was} -> {value}")


def _shapes(before: Usd.Stage, now: Usd.Stage, changed: Settings) -> Iterator[Finding]:
    scenes = find_scene(before), find_scene(now)
    lineage = lineage_of(now)
    for old, new in _pairs(scenes[0].hair, scenes[1].hair):
        if old is None or new is None:
            shape = new or old
            assert shape is not None
            yield _change("count", str(shape.prim.GetPath()), "the hair is new" if old is None else "the hair is gone")
        else:
            for finding in _hair(_Pair(Hair(scenes[0], old), Hair(scenes[1], new))):
                yield _caused(finding, lineage, changed)
    for old, new in _pairs(scenes[0].meshes, scenes[1].meshes):
        if old is not None and new is not None:
            for finding in _body(scenes, old, new):
                yield _caused(finding, lineage, changed)


def _pairs(old: list[Track], new: list[Track]) -> list[tuple[Track | None, Track | None]]:
    """Pair shapes by path; one of each side belong together whatever they are called."""
    if len(old) == len(new) == 1:
        return [(old[0], new[0])]
    sides = [{track.prim.GetPath(): track for track in tracks} for tracks in (old, new)]
    return [(sides[0].get(path), sides[1].get(path)) for path in sorted({*sides[0], *sides[1]})]


def _caused(finding: Finding, lineage: Lineage | None, changed: Settings) -> Finding:
    """Name the changed settings before an attribute, the nearest first, and how to undo them."""
    if lineage is None:
        return finding
    behind = [name for socket in socket_of(finding.path) for name in lineage.behind(socket)]
    order = [lineage.node, *(behind or lineage.upstream("hair"))]
    own = {f"{lineage.node}.{name}" for name in (*EXPORTED.get(finding.rule, ()), "type")}
    own |= {f"{lineage.node}.in.{socket}" for socket in socket_of(finding.path)}
    named = [(s, p) for name in (*order, SHOT) for s, p in changed.items() if _is_of(s, name, lineage.node, own)]
    named = named[:LISTED]
    if not named:
        return finding
    undo = ", ".join(f"{name} = {_text(was)}" for name, (was, _) in named)
    settings = {name: value for name, (_, value) in named}
    return Finding(**{**vars(finding), "cause": Cause(named[0][0].partition(".")[0], settings, f"{undo} to undo")})


def _is_of(setting: str, name: str, export: str, own: set[str]) -> bool:
    """Whether a setting is one of a node; of the export only those of `own` count."""
    if name in (SHOT, export):
        return "." not in setting if name == SHOT else setting in own
    return setting.startswith(f"{name}.")


@dataclass(frozen=True)
class Hair:
    """Hair of a stage, in metres with Y up."""

    scene: Scene
    track: Track

    def placed(self, shape: Snapshot) -> np.ndarray:
        """Return the points of a shape, (p, 3) [m]."""
        return shape.placed @ self.scene.metres[:3, :3].T + self.scene.metres[:3, 3]

    @cached_property
    def scale(self) -> float:
        """Metres per unit of the points."""
        return float(np.cbrt(abs(np.linalg.det(self.scene.metres[:3, :3] @ self.track.first.world[:3, :3].T))))

    @cached_property
    def ids(self) -> np.ndarray:
        """Ids of the strands, (c,); their numbers where they have none of their own."""
        count = len(self.track.first.counts)
        given = (self.track.first.array(f"primvars:{name}") for name in IDS)
        found = next((ids for ids in given if ids is not None and len(np.unique(ids)) == count), None)
        return np.arange(count) if found is None else found

    @cached_property
    def rest(self) -> Snapshot:
        return self.track.still or self.track.first

    @cached_property
    def roots(self) -> np.ndarray:
        """Roots at rest, (c, 3) [m]."""
        return self.placed(self.rest)[self.rest.roots]

    @cached_property
    def widths(self) -> np.ndarray | None:
        """Widths of the strands at their roots, (c,) [m]."""
        values = self.track.first.array("widths")
        whole = values is not None and len(values) == len(self.track.first.points)
        return values[self.track.first.roots] * self.scale if whole and values is not None else None


class _Pair:
    """The strands that two hairs share, by their ids, and the region of each.

    rows  of the shared strands in the earlier and in the new hair, (s,) each
    """

    def __init__(self, old: Hair, new: Hair) -> None:
        self.old, self.new = old, new
        self.ids, *rows = np.intersect1d(old.ids, new.ids, return_indices=True)
        self.rows = rows
        old_counts, new_counts = (hair.track.first.counts for hair in (old, new))
        self.alike = self.sound and np.array_equal(old_counts[rows[0]], new_counts[rows[1]])

    @property
    def sides(self) -> list[tuple[Hair, np.ndarray]]:
        return list(zip((self.old, self.new), self.rows, strict=True))

    @property
    def sound(self) -> bool:
        return all(hair.track.first.sound for hair in (self.old, self.new))

    @cached_property
    def regions(self) -> np.ndarray:
        """Region in which each shared strand had its root, (s,)."""
        return self.regions_of(self.old)[self.rows[0]]

    def regions_of(self, hair: Hair) -> np.ndarray:
        """Return the side of the earlier scalp on which each root is, (c,): the axis nearest to the way there."""
        centre = (self.old.roots.min(axis=0) + self.old.roots.max(axis=0)) / 2
        away = hair.roots - centre
        axis = np.abs(away).argmax(axis=1)
        return SIDES[2 * axis + (away[np.arange(len(away)), axis] < 0)]

    @cached_property
    def ways(self) -> np.ndarray:
        """Distances between the roots of shared strands at rest, (s,) [m]."""
        roots = [hair.roots[rows] for hair, rows in self.sides]
        return np.linalg.norm(roots[1] - roots[0], axis=1)

    @cached_property
    def same(self) -> bool:
        """Whether ids name the same strands: their roots are where they were, but for some."""
        return float(np.median(self.ways)) <= OTHERS * float(np.linalg.norm(np.ptp(self.old.roots, axis=0)))

    def by_region(self, values: np.ndarray) -> dict[str, float]:
        """Return the largest value of each region."""
        return {side: float(values[self.regions == side].max()) for side in SIDES if (self.regions == side).any()}


def _hair(pair: _Pair) -> Iterator[Finding]:
    path = str(pair.new.track.prim.GetPath())
    old, new = pair.old, pair.new
    added, gone = (int(len(hair.ids) - len(pair.ids)) for hair in (new, old))
    if added or gone:
        yield _change(
            "count", f"{path}.primvars:hairId", f"{len(old.ids)} -> {len(new.ids)} strands: {added} new, {gone} gone"
        )
    if not pair.sound or not len(pair.ids):
        return
    counts = [hair.track.first.counts[rows] for hair, rows in pair.sides]
    if not pair.alike:
        texts = [f"{c.min()} to {c.max()}" if np.ptp(c) else str(c[0]) for c in counts]
        yield _change("count", f"{path}.primvars:hairId", f"{texts[0]} -> {texts[1]} points a strand")
    if not pair.same:
        far = MILLIMETRES * np.median(pair.ways)
        message = f"ids name other strands than before, {far:.3g} mm away in the median: only sums are compared"
        yield _change("roots", f"{path}.primvars:hairId", message)
        medians = [f"{MILLIMETRES * np.median(hair.rest.lengths) * hair.scale:.3g}" for hair in (old, new)]
        if medians[0] != medians[1]:
            yield _change("lengths", f"{path}.primvars:pref", f"{medians[0]} -> {medians[1]} mm in the median")
        yield from _bounds(pair, path)
        return
    yield from _moved("roots", f"{path}.primvars:pref", pair, pair.ways, "roots moved")
    lengths = [hair.rest.lengths[rows] * hair.scale for hair, rows in pair.sides]
    yield from _scaled("lengths", f"{path}.primvars:pref", pair, *lengths)
    widths = [None if hair.widths is None else hair.widths[rows] for hair, rows in pair.sides]
    if widths[0] is not None and widths[1] is not None:
        yield from _scaled("widths", f"{path}.widths", pair, widths[0], widths[1])
    yield from _motion(pair, path)
    yield from _bounds(pair, path)


def _moved(
    rule: str, path: str, pair: _Pair, far: np.ndarray, what: str, time: float | None = None
) -> Iterator[Finding]:
    moved = far > MOVED
    if moved.any():
        worst = int(far.argmax())
        values = {side: MILLIMETRES * value for side, value in pair.by_region(far).items()}
        message = (
            f"{moved.sum()} of {len(far)} {what}, the strand {pair.ids[worst]} by {MILLIMETRES * far[worst]:.3g} mm"
        )
        yield _change(rule, path, f"{message}; {_listed(values, ' mm')}", time, values)


def _scaled(rule: str, path: str, pair: _Pair, was: np.ndarray, now: np.ndarray) -> Iterator[Finding]:
    ratio = now / np.maximum(was, np.finfo(float).tiny)
    other = np.abs(ratio - 1.0) > RATIO
    if other.any():
        sides = [side for side in SIDES if (pair.regions == side).any()]
        values = {side: float(np.median(ratio[pair.regions == side])) for side in sides}
        medians = f"{MILLIMETRES * np.median(was):.3g} -> {MILLIMETRES * np.median(now):.3g} mm in the median"
        message = f"{other.sum()} of {len(ratio)} strands differ, {medians}"
        yield _change(rule, path, f"{message}; ratio {_listed(values, '')}", None, values)


def _listed(values: dict[str, float], unit: str) -> str:
    return ", ".join(f"{side} {value:.3g}{unit}" for side, value in values.items())


def _motion(pair: _Pair, path: str) -> Iterator[Finding]:
    """Compare the points of shared strands at the times that both have."""
    first = worst = None
    largest = np.zeros(len(pair.ids))
    for time, shapes in _together(pair) if pair.alike else ():
        points = [hair.placed(s)[_rows_of(s, rows)] for (hair, rows), s in zip(pair.sides, shapes, strict=True)]
        counts = shapes[1].counts[pair.rows[1]]
        far = np.maximum.reduceat(np.linalg.norm(points[1] - points[0], axis=1), np.cumsum(counts) - counts)
        first = time if first is None and (far > MOVED).any() else first
        worst = time if far.max() > largest.max() else worst
        largest = np.maximum(largest, far)
    since = "" if first is None else f" from {first:g} on"
    yield from _moved("motion", f"{path}.points", pair, largest, f"strands move differently{since}", worst)


def _bounds(pair: _Pair, path: str) -> Iterator[Finding]:
    """Compare the boxes around all strands of each region, over the times that both have."""
    boxes = [dict[str, np.ndarray](), dict[str, np.ndarray]()]
    sides = [pair.regions_of(hair) for hair in (pair.old, pair.new)]
    for _, shapes in _together(pair):
        for (hair, _), shape, own, box in zip(pair.sides, shapes, sides, boxes, strict=True):
            points = hair.placed(shape)
            owners = np.repeat(own, shape.counts)
            for side in np.unique(own):
                corners = np.stack([points[owners == side].min(axis=0), -points[owners == side].max(axis=0)])
                box[side] = np.minimum(box.get(side, corners), corners)
    shifts = {side: float(np.abs(boxes[1][side] - boxes[0][side]).max()) for side in boxes[0] if side in boxes[1]}
    if any(shift > MOVED for shift in shifts.values()):
        values = {side: MILLIMETRES * shifts[side] for side in SIDES if side in shifts}
        whole = [np.min(list(box.values()), axis=0) for box in boxes]
        sizes = [" x ".join(f"{-(low + high):.3g}" for low, high in box.T) for box in whole]
        message = f"the hair fills {sizes[0]} -> {sizes[1]} m; a side moved by up to {_listed(values, ' mm')}"
        yield _change("bounds", f"{path}.extent", message, None, values)


def _together(pair: _Pair) -> Iterator[tuple[float | None, list[Snapshot]]]:
    """Yield the two hairs at each time that both have, where both are as long as at first."""
    for time in sorted({*pair.old.track.points} & {*pair.new.track.points}) or [None]:
        shapes = [hair.track.at(time) for hair in (pair.old, pair.new)]
        firsts = [hair.track.first for hair in (pair.old, pair.new)]
        alike = (np.array_equal(s.counts, first.counts) for s, first in zip(shapes, firsts, strict=True))
        if all(shape.sound for shape in shapes) and all(alike):
            yield time, shapes


def _rows_of(shape: Snapshot, rows: np.ndarray) -> np.ndarray:
    """Return the points of some strands, one after the other."""
    counts = shape.counts[rows]
    return np.repeat(shape.roots[rows] - (np.cumsum(counts) - counts), counts) + np.arange(counts.sum())


def _body(scenes: tuple[Scene, Scene], old: Track, new: Track) -> Iterator[Finding]:
    path = f"{new.prim.GetPath()}.points"
    if not np.array_equal(old.first.corners, new.first.corners) or len(old.first.points) != len(new.first.points):
        faces = [len(track.first.counts) for track in (old, new)]
        yield _change("body", path, f"other triangles: {faces[0]} -> {faces[1]} faces")
        return
    times = sorted({*old.points} & {*new.points}) if old.moves and new.moves else [None]
    far = {time: _apart(scenes, old, new, time) for time in times}
    moved = [time for time, distance in far.items() if distance > MOVED]
    if moved:
        worst = max(far, key=lambda time: far[time])
        since = "" if moved[0] is None else f" from {moved[0]:g} on"
        yield _change("body", path, f"moves differently{since}, by up to {MILLIMETRES * far[worst]:.3g} mm", worst)


def _apart(scenes: tuple[Scene, Scene], old: Track, new: Track, time: float | None) -> float:
    places = [s.place(t, time) @ s.metres[:3, :3].T + s.metres[:3, 3] for s, t in zip(scenes, (old, new), strict=True)]
    return float(np.linalg.norm(places[1] - places[0], axis=1).max(initial=0.0))


def _change(
    rule: str, path: str, message: str, time: float | None = None, values: dict[str, float] | None = None
) -> Finding:
    return Finding(rule, path, time, message, "change", values=values or {})
