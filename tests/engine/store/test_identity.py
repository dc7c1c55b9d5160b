"""The identity of a store is given once, whoever asks at one time."""

import os
from concurrent.futures import ThreadPoolExecutor

from hairpipe.engine.hosts.offer import claim_identity, identity_of
from hairpipe.engine.store.store import Store


def test_all_who_ask_at_one_time_get_the_same(tmp_path):
    for number in range(20):
        store = Store(tmp_path / str(number))
        assert identity_of(store.root) is None
        with ThreadPoolExecutor(6) as threads:
            found = set(threads.map(lambda _, store=store: claim_identity(store), range(6)))
        assert found == {identity_of(store.root)} and len(found) == 1


def test_a_damaged_one_is_replaced_and_a_group_reads_it(tmp_path):
    store = Store(tmp_path)
    (tmp_path / "id").write_text("damaged")
    tmp_path.chmod(0o775)
    before = os.umask(0o077)
    found = claim_identity(store)
    os.umask(before)
    assert identity_of(tmp_path) == found and (tmp_path / "id").stat().st_mode & 0o040
