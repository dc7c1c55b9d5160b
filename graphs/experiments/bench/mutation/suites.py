"""The tests that a change of each file of the engine is tried with: those of that file, quickest first.

Others of the whole suite may find what they miss: a score is a lower bound.
"""

ROOM = "hairpipe/engine"
TESTS = "tests/engine"
KEY = ("code.py", "plan/key.py")
"""Files that make keys: a room of their own here; the others are folders."""
SUITES: dict[str, tuple[str, ...]] = {
    "code.py": ("key", "worker/test_machine_code.py", "worker/test_kernel_cache.py"),
    "plan/key.py": ("plan/test_planner.py", "file/test_load.py", "plan/test_divergence.py", "run/test_scheduler.py"),
    "store/atomic.py": ("store/test_atomic.py", "store/test_ownership.py", "test_leases.py", "test_users.py"),
    "store/digest.py": ("store/test_digest.py", "store/test_record.py", "store/test_kept_stores.py", "key"),
    "store/fingerprint.py": (
        *("store/test_fingerprint.py", "store/test_seal.py", "key", "test_damage.py", "run/test_scheduler.py"),
    ),
    "store/holder.py": ("store/test_holder.py", "store/test_atomic.py", "store/test_lease.py"),
    "store/lease.py": (
        *("store/test_lease.py", "test_leases.py", "test_notes.py", "test_read_only.py", "plan/test_divergence.py"),
    ),
    "store/ownership.py": ("store/test_ownership.py", "test_users.py"),
    "store/record.py": ("store/test_record.py", "store/test_kept_stores.py", "test_damage.py"),
    "store/store.py": (
        *("store/test_store.py", "store/test_identity.py", "store/test_kept_stores.py", "store/test_values.py"),
        *("test_notes.py", "test_users.py", "test_read_only.py", "test_damage.py"),
    ),
    "store/values.py": ("store/test_values.py", "store/test_kept_stores.py", "test_damage.py"),
    "run/events.py": ("run/test_events.py", "../app/cli/test_lines.py", "run/test_scheduler.py"),
    "run/player.py": ("run/test_player.py",),
    "run/publish.py": ("run/test_publish.py", "file/test_bounds.py"),
    "run/scheduler.py": (
        "run/test_queue.py",
        *("run/test_scheduler.py", "test_faults.py"),
        "plan/test_portion.py::test_a_run_waits_so_long_for_others_and_ends_with_75",
    ),
    "run/survey.py": ("plan/test_divergence.py", "test_read_only.py", "../app/cli/commands/test_watch.py"),
}


def room_of(file: str) -> str:
    """Name the room of a file: key, or its folder."""
    return "key" if file in KEY else file.partition("/")[0]
