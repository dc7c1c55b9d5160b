"""The tests that a change of each file of the engine and of the laws is tried with: those of that file, quickest first.

Others of the whole suite may find what they miss: a score is a lower bound.
"""

PACKAGE, TESTS = "hairpipe", "tests"
ENGINE: dict[str, tuple[str, ...]] = {
    "code.py": ("key", "plan/test_planner.py", "worker/test_machine_code.py", "worker/test_kernel_cache.py"),
    "plan/key.py": (
        *("plan/test_key.py", "plan/test_planner.py", "test_spent.py", "file/test_load.py", "plan/test_checkpoints.py"),
        *("plan/test_divergence.py", "run/test_scheduler.py"),
    ),
    "store/atomic.py": (
        *("store/test_atomic.py", "store/test_ownership.py", "store/test_values.py", "plan/test_maintenance.py"),
        *("test_leases.py", "test_users.py", "test_damage.py"),
    ),
    "store/digest.py": ("store/test_digest.py", "store/test_store.py", "store/test_kept_stores.py", "key"),
    "store/fingerprint.py": (
        *("store/test_fingerprint.py", "store/test_seal.py", "key", "test_damage.py", "run/test_scheduler.py"),
    ),
    "store/holder.py": ("store/test_holder.py", "store/test_atomic.py", "store/test_lease.py", "test_leases.py"),
    "store/lease.py": (
        *("store/test_lease.py", "test_leases.py", "store/test_store.py", "test_read_only.py"),
        *("plan/test_divergence.py", "test_faults.py"),
    ),
    "store/ownership.py": ("store/test_ownership.py", "test_users.py"),
    "store/store.py": (
        *("store/test_store.py", "store/test_identity.py", "store/test_kept_stores.py", "store/test_values.py"),
        *("test_users.py", "test_read_only.py", "test_damage.py", "plan/test_maintenance.py"),
    ),
    "store/values.py": (
        *("store/test_values.py", "store/test_kept_stores.py", "test_spent.py", "test_damage.py", "test_users.py"),
        *("test_faults.py", "run/test_scheduler.py"),
    ),
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

"""Files of `hairpipe/engine`, and tests in `tests/engine`."""
LAWS: dict[str, tuple[str, ...]] = {
    "adhesion.py": ("../contact/hair/test_stiction.py",),
    "altitude.py": ("test_altitude.py",),
    "bend_twist.py": ("test_bend_twist.py",),
    "bending.py": ("test_bending.py",),
    "coulomb.py": ("test_coulomb.py",),
    "drag.py": ("test_drag.py",),
    "fold_preservation.py": ("test_fold_preservation.py",),
    "goal.py": ("test_goal.py", "../shot/test_pull.py"),
    "gusts.py": ("test_gusts.py",),
    "pressure.py": ("test_pressure.py",),
    "repulsion.py": ("test_repulsion.py", "../contact/hair/test_repulsion.py"),
    "strain_limit.py": ("test_strain_limit.py",),
    "stretch.py": ("test_spring.py",),
}
"""Files of `hairpipe/laws`, and tests in `tests/laws`; their settings are of no law."""
SUITES = {
    f"{room}/{file}": tuple(f"{room}/{test}" for test in tests)
    for room, suites in (("engine", ENGINE), ("laws", LAWS))
    for file, tests in suites.items()
}
KEY = ("engine/code.py", "engine/plan/key.py")
"""Files that make keys: a room of their own here; the others are folders."""


def room_of(file: str) -> str:
    """Name the room of a file: key, laws, or its folder in the engine."""
    return "key" if file in KEY else file.removeprefix("engine/").partition("/")[0]
