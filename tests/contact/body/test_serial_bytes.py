"""A frame of hair in contact does little outside of parallel kernels: counted in bytes, not timed.

Each array that a line of Python allocates counts by its bytes, except those of `np.empty` and `np.zeros`, which kernels
fill. What numpy computes in place is not counted.
"""

import sys
import tracemalloc
from collections import Counter
from dataclasses import replace
from functools import partial
from pathlib import Path

import numpy as np

import hairpipe
from hairpipe.laws.settings import Collisions, Stiction, StrainLimit
from hairpipe.levelset.bake import bake
from hairpipe.levelset.collider_field import build_collider_field
from hairpipe.levelset.sample import Interpolation
from hairpipe.shot.simulate import advance_frame
from hairpipe.values import Mesh

HOUSE = str(Path(hairpipe.__file__).parent)
MOST = 1000.0
"""Bytes a point and step, of which kernels take some themselves: 980; a line of numpy in `BodyContacts.look`: 250."""


def counted(work, monkeypatch):
    """Count the bytes that each line of the package allocates in some work: by file and line."""
    made, last, blank = Counter(), [("", 0), 0], [0]

    def note(allocate, *arguments, **settings):
        out = allocate(*arguments, **settings)
        blank[0] += out.nbytes
        return out

    def settle(line):
        now, peak = tracemalloc.get_traced_memory()
        made[last[0]] += max(peak - last[1] - blank[0], 0)
        tracemalloc.reset_peak()
        last[:], blank[0] = [line, now], 0

    def trace(frame, event, _):
        file = frame.f_code.co_filename
        if not file.startswith(HOUSE):
            return None
        settle((file, frame.f_lineno))
        return trace

    for name in ("empty", "empty_like", "zeros", "zeros_like"):
        monkeypatch.setattr(np, name, partial(note, getattr(np, name)))
    before = sys.gettrace()
    tracemalloc.start()
    sys.settrace(trace)
    try:
        work()
        settle(("", 0))
    finally:
        sys.settrace(before)
        tracemalloc.stop()
    return made


def slab():
    """A flat box under the hair, as a collider at rest."""
    corners = np.array([[x, y, z] for x in (0.0, 0.15) for y in (-0.03, -0.004) for z in (-0.1, 0.04)])
    quads = np.array([[0, 1, 3, 2], [4, 6, 7, 5], [0, 4, 5, 1], [2, 3, 7, 6], [0, 2, 6, 4], [1, 5, 7, 3]], np.int32)
    triangles = np.concatenate([quads[:, [0, 1, 2]], quads[:, [0, 2, 3]]])
    surface = bake(Mesh(corners, triangles, np.zeros((8, 3))), 0.004, 6.0)
    return build_collider_field(surface, surface, 1 / 24, Interpolation.two_sided)


def bytes_of(shot, monkeypatch):
    """Return the number of points of hair on a slab, and the bytes that lines of Python allocate in a step of it."""
    shot.scene = replace(shot.scene, strain=StrainLimit(), stiction=Stiction(), collisions=Collisions())
    bodies = [slab()]
    shot.run(2 / 24, bodies)
    steps, roots = [], (shot.body, shot.body)

    def advance():
        advance_frame(shot.hair, shot.state, roots, bodies, shot.frame, shot.scene, watch=lambda *at: steps.append(at))

    with monkeypatch.context() as patch:
        made = counted(advance, patch)
    return shot.hair.layout.offsets[-1], made.total() / len(steps)


def test_steps_allocate_few_bytes_for_each_point(scene, straight, monkeypatch):
    hair, apart = straight(0.1, 20, [1, 0, 0]), np.array([0, 0, 3e-4])
    shots = (scene([hair + k * apart for k in range(count)]) for count in (80, 240))
    (few, less), (many, more) = (bytes_of(shot, monkeypatch) for shot in shots)
    assert (more - less) / (many - few) < MOST  # Of the difference: what does not grow with the hair is left out.
