"""The time of a frame is shared out whole, and every file has its part."""

from pathlib import Path

import numpy as np
import pytest

from hairpipe import contact
from hairpipe.geometry import segments as pairs
from hairpipe.geometry.segments import key_of
from hairpipe.graphs.experiments.bench import shares
from hairpipe.graphs.experiments.bench.shares import PARTS, part_of, shares_of

CONTACT = Path(contact.__file__).parent


def test_every_file_of_contact_is_in_one_part():
    named = [name for names in shares._FILES.values() for name in names]
    assert {f"contact/{path.stem}" for path in CONTACT.glob("*.py")} - {"contact/__init__"} <= set(named)
    assert len(named) == len(set(named)) and set(shares._FILES) | set(shares._ROOMS.values()) < set(PARTS)
    assert not [name for name in named if not (CONTACT.parent / f"{name}.py").is_file()]


def test_files_outside_have_theirs():
    assert part_of(CONTACT.parent / "solve" / "implicit_stage.py") == "strands"
    assert part_of(CONTACT.parent / "solve" / "surroundings.py") == "coupling"
    assert part_of(Path(pairs.__file__)) == "search"
    assert part_of(CONTACT.parent / "levelset" / "collider.py") == "body"


def test_shares_are_found_in_a_program_with_many_paths():
    """A layer of forty functions calls all of the next: 40^8 paths, of which each function is visited once a depth."""
    layers = [[(f"/library/{depth}.py", line, "call") for line in range(40)] for depth in range(9)]
    ours = (str(shares._HOUSE / "shot" / "shot.py"), 1, "advance")
    stats = {function: (1, 1, 0.5, 1.0, {}) for function in (ours, *layers[0])}
    for above, below in zip([[ours], *layers], layers, strict=False):
        stats |= {function: (1, 1, 0.5, 1.0, {caller: (1, 1, 0.1, 1.0) for caller in above}) for function in below}
    known = {}
    assert shares._weights(layers[6][0], stats, 0, known) == pytest.approx({ours[0]: 1.0})
    assert len(known) <= 7 * 40 + 1


def test_time_in_numpy_counts_for_the_caller():
    segments = np.random.default_rng(0).integers(0, 10**6, (3_000_000, 2)).astype(np.int32)
    key_of(segments)  # what is loaded or compiled at first has no part
    whole, parts = shares_of(lambda: [key_of(segments) for _ in range(40)])
    assert parts["search"] > 0.9 * sum(parts.values()) > 0.0
    assert sum(parts.values()) == pytest.approx(whole, rel=0.05)
