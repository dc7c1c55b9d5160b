"""A corpus of damaged texts: whatever the engine reads as text is a value or one message, never another exception.

`python -m tests.engine.test_corpus` damages what is in the corpus at random, and adds what reaches new lines.
"""

import os
import random
import shutil
import sys
import tempfile
from collections.abc import Callable
from contextlib import suppress
from pathlib import Path
from typing import Any

import pytest

from hairpipe.engine.file.load import load_graph
from hairpipe.engine.run import publish as ledger
from hairpipe.engine.store.digest import digest, digest_bytes
from hairpipe.engine.store.lease import FailureNote, Lease, read_lease, recall_failure
from hairpipe.engine.store.store import MARK, Record, Store, read_record
from hairpipe.engine.store.values import Listing, parse_listing
from hairpipe.errors import BadInput

CORPUS = Path(__file__).parent / "corpus"
KEY = "0c" * 20


def as_text(data: bytes) -> str:
    return data.decode(errors="replace")


def as_record(folder: Path, data: bytes) -> Record | None:
    return read_record(as_text(data))


def as_checked_record(folder: Path, data: bytes) -> Record | None:
    """Read what somebody has written who knows how records are checked."""
    body = as_text(data).rpartition(MARK)[0] or as_text(data)[:-1]
    return read_record(f'{body}{MARK}{digest_bytes("record", f"{body}}}".encode(errors="replace"))}"}}')


def as_listing(folder: Path, data: bytes) -> Listing | None:
    (folder / "listing").write_bytes(data)
    return parse_listing(folder / "listing")


def as_lease(folder: Path, data: bytes) -> Lease | None:
    (folder / "lease").write_bytes(data)
    return read_lease(folder / "lease")


def as_note(folder: Path, data: bytes) -> str | None:
    store = Store(folder / "store")
    store.note(KEY, "")
    (store.root / "notes" / KEY[:2] / KEY).write_bytes(data)
    return store.recall(KEY)


def as_failure(folder: Path, data: bytes) -> FailureNote | None:
    store = Store(folder / "store")
    store.note(digest("failure", KEY), as_text(data))
    return recall_failure(store, KEY)


def as_latest(folder: Path, data: bytes) -> dict[str, str]:
    store = Store(folder / "store")
    store.set_latest("a", "b", {"1": KEY})
    (store.root / "latest" / "a" / "b.json").write_bytes(data)
    return store.latest("a", "b")


def as_ledger(folder: Path, data: bytes) -> dict[str, str]:
    (folder / "ledger").write_bytes(data)
    return ledger.read(folder / "ledger")


def as_graph(folder: Path, data: bytes) -> object:
    (folder / "shot.toml").write_bytes(data)
    return load_graph(folder / "shot.toml", {})


READERS: dict[str, tuple[Callable[[Path, bytes], object], Any]] = {
    "record": (as_record, Record | None),
    "checked_record": (as_checked_record, Record | None),
    "listing": (as_listing, Listing | None),
    "lease": (as_lease, Lease),
    "note": (as_note, str | None),
    "failure": (as_failure, FailureNote | None),
    "latest": (as_latest, dict),
    "ledger": (as_ledger, dict),
    "graph": (as_graph, object),
}
"""What reads a text, and what it makes of any."""


@pytest.mark.parametrize("reader", READERS)
def test_readers_return_a_value_or_one_message(shot, reader):
    read, kind = READERS[reader]
    texts = sorted(CORPUS.iterdir())
    assert texts
    for path in texts:
        try:
            assert isinstance(read(shot.folder, path.read_bytes()), kind), path.name
        except BadInput as error:
            assert reader == "graph" and len(str(error).splitlines()) == 1, path.name


def test_each_reader_finds_a_sound_text(shot):
    """Or the corpus would be one of texts that are refused at once."""
    found = set()
    for path in CORPUS.iterdir():
        for reader, (read, _) in READERS.items():
            with suppress(BadInput):
                found |= {reader} if read(shot.folder, path.read_bytes()) else set()
    assert found == set(READERS)


def test_a_failure_is_two_texts(shot):
    assert as_failure(shot.folder, b'["here", "no faces"]') == FailureNote("here", "no faces")
    for text in (b'"ab"', b'["here", 1]', b'{"a": 1, "b": 2}'):
        assert as_failure(shot.folder, text) is None


WORDS = [b"null", b"NaN", b"-1", b"1e999", b"[]", b"{}", b'""', b'"\\ud800"', b"true", b"\xff", b"\n"]
WORDS += [b"9" * 400, b"[" * 3000]
TRIALS = 2500


def damaged(data: bytes, draw: random.Random) -> bytes:
    """Damage a text at one to three places."""
    for _ in range(draw.randint(1, 3)):
        at, to = sorted((draw.randrange(len(data) + 1), draw.randrange(len(data) + 1)))
        to = draw.choice([to, min(len(data), at + draw.randint(0, 8))])
        put = draw.choice([b"", bytes([draw.randrange(256)]), draw.choice(WORDS), data[at:to] * 2])
        data = data[:at] + put + data[to:]
    return data


def reached(read: Callable[[Path, bytes], object], folder: Path, data: bytes) -> frozenset[tuple[str, int]]:
    """Read a text; returns the lines of the engine that were reached."""
    lines = set()

    def trace(frame, event, argument):
        if "/hairpipe/engine/" not in frame.f_code.co_filename:
            return None
        lines.add((frame.f_code.co_filename, frame.f_lineno))
        return trace

    sys.settrace(trace)
    try:
        with suppress(BadInput):
            read(folder, data)
    except Exception as error:
        lines.add((repr(type(error)), -1))
        print(f"{read.__name__}: {error!r}", file=sys.stderr)
    finally:
        sys.settrace(None)
    return frozenset(lines)


def grow(folder: Path, seed: int) -> None:
    """Add to the corpus what reaches new lines."""
    draw = random.Random(seed)
    texts = [path.read_bytes() for path in sorted(CORPUS.iterdir())]
    known = {name: set() for name in READERS}
    for number in range(len(texts) + TRIALS):
        data = texts[number] if number < len(texts) else damaged(draw.choice(texts), draw)[:4000]
        new = False
        for name, (read, _) in READERS.items():
            lines = reached(read, folder, data) - known[name]
            known[name] |= lines
            new |= bool(lines)
        if new and data not in texts:
            texts.append(data)
            (CORPUS / digest_bytes("corpus", data)[:12]).write_bytes(data)


if __name__ == "__main__":
    with tempfile.TemporaryDirectory() as place:
        shutil.copytree(Path(__file__).parent / "toys", Path(place) / "nodes")
        os.environ["HAIRPIPE_TRUST"] = str(Path(place) / "nodes")
        grow(Path(place), int(sys.argv[1]) if sys.argv[1:] else 0)
