"""Records of other versions, and of damaged disks."""

import json

from hairpipe.engine.store.digest import digest_bytes
from hairpipe.engine.store.store import MARK, Output, Record, read_record, write_record

PARTS = {"type": "toy", "code": "c", "settings": {}, "inputs": {}, "time": None}
RECORD = Record("a" * 40, "hair", 7, PARTS, {"": Output("b" * 40 + ".h5", 3)}, None, 1.5, ("odd",), 1e9, 1.25)


def test_a_record_is_read_as_it_was_written():
    assert read_record(write_record(RECORD)) == RECORD


def of_another_version(change):
    """Read a record with fields that were changed before it was written."""
    fields = json.loads(write_record(RECORD))
    del fields["check"]
    change(fields)
    text = json.dumps(fields, separators=(",", ":"))
    return read_record(f'{text[:-1]}{MARK}{digest_bytes("record", text.encode())}"}}')


def test_a_record_of_an_older_version_lacks_the_seconds_of_the_processor():
    found = of_another_version(lambda fields: fields.pop("processor"))
    assert found is not None and found.processor is None and found.seconds == 1.5


def test_a_record_of_a_newer_version_is_read_but_for_what_is_new():
    assert of_another_version(lambda fields: fields.update(memory=7)) == RECORD


def test_a_record_with_a_changed_byte_is_none():
    assert read_record(write_record(RECORD).replace("1.5", "1.6")) is None
