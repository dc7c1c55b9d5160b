"""The time of a frame is shared out whole, and every file has its part."""

from pathlib import Path

import numpy as np
import pytest

from hairpipe.bench import shares
from hairpipe.bench.shares import PARTS, part_of, shares_of
from hairpipe.spatial import pair_collection
from hairpipe.spatial.pairs import key_of

ROOM = Path(pair_collection.__file__).parent


def test_every_file_of_contact_is_in_one_part():
    named = [stem for stems in shares._OF_CONTACT.values() for stem in stems]
    assert sorted(named) == sorted(path.stem for path in ROOM.glob("*.py") if path.stem != "__init__")
    assert set(shares._OF_CONTACT) < set(PARTS)


def test_files_outside_have_theirs():
    assert part_of(ROOM.parent / "stage.py") == "strands"
    assert part_of(ROOM.parent / "response.py") == "coupling"
    assert part_of(ROOM.parents[1] / "levelset" / "moving.py") == "body"


def test_what_numpy_does_counts_for_who_asked_it():
    segments = np.random.default_rng(0).integers(0, 10**6, (3_000_000, 2)).astype(np.int32)
    whole, parts = shares_of(lambda: key_of(segments))
    assert parts["stiction"] > 0.9 * sum(parts.values()) > 0.0
    assert sum(parts.values()) == pytest.approx(whole, rel=0.05)
