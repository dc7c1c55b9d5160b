"""Kernels lie where only their user can write, and stores of others are not believed unasked."""

import os
from pathlib import Path

import pytest

from hairpipe.engine.hosts.host import Host
from hairpipe.engine.store import ownership
from hairpipe.engine.store.ownership import TRUST, check_store
from hairpipe.engine.worker.machine_code import TABLE, claim_kernels, kernels_parent
from hairpipe.errors import BadInput


@pytest.fixture
def somebody_else(monkeypatch):
    """Be a user to whom nothing here belongs, and who is not root."""
    monkeypatch.setattr(ownership.os, "geteuid", lambda: os.getuid() + 12345)
    real = Path.stat

    def owned(self, **options):
        found = list(real(self, **options))
        return os.stat_result([*found[:4], found[4] + 1, *found[5:]])

    monkeypatch.setattr(Path, "stat", owned)


def test_the_folder_is_made_for_its_user_alone(tmp_path):
    before = os.umask(0o002)
    folder = claim_kernels(tmp_path / "new" / "home" / "deep" / "kernels")
    os.umask(before)
    assert folder.stat().st_mode & 0o777 == 0o700 and claim_kernels(folder) == folder


def test_a_folder_that_others_may_write_to_or_that_is_theirs_is_refused(tmp_path, request):
    for mode in (0o770, 0o702, 0o777):
        tmp_path.chmod(mode)
        with pytest.raises(BadInput, match=f"{tmp_path}: .* can be written to by others .*chmod go-w"):
            claim_kernels(tmp_path)
    request.getfixturevalue("somebody_else")
    with pytest.raises(BadInput, match="belongs to somebody else"):
        claim_kernels(tmp_path)


def test_a_run_refuses_kernels_of_others_with_one_line(shot, monkeypatch):
    folder = shot.folder / "told" / "hairpipe"
    folder.mkdir(parents=True)
    folder.chmod(0o777)
    monkeypatch.setenv("NUMBA_CACHE_DIR", str(folder.parent))
    with pytest.raises(BadInput, match="can be written to by others"):
        shot.run()
    assert shot.tally() == {}


def test_where_kernels_lie(monkeypatch):
    def place(**variables):
        for name in ("NUMBA_CACHE_DIR", "XDG_CACHE_HOME", "HOME"):
            monkeypatch.delenv(name, raising=False)
        for name, value in variables.items():
            monkeypatch.setenv(name, value)
        return str(kernels_parent())

    assert place(NUMBA_CACHE_DIR="/told", XDG_CACHE_HOME="/x", HOME="/h") == "/told/hairpipe"
    assert place(XDG_CACHE_HOME="/x", HOME="/h") == "/x/hairpipe/kernels"
    assert place(XDG_CACHE_HOME="relative", HOME="/h") == "/h/.cache/hairpipe/kernels"
    monkeypatch.setattr(os.path, "expanduser", no_home)
    with pytest.raises(OSError, match="no home"):
        place()


def no_home(path):
    """Know no home, as Python does where neither the environment nor the system tells of one."""
    return path


@pytest.mark.parametrize("home", ["nowhere", "unwritable"])
def test_without_a_home_kernels_are_of_one_run_and_it_reports_it(shot, monkeypatch, home):
    monkeypatch.delenv("NUMBA_CACHE_DIR", raising=False)
    monkeypatch.delenv("XDG_CACHE_HOME", raising=False)
    if home == "nowhere":
        monkeypatch.setattr(os.path, "expanduser", no_home)
    else:
        (shot.folder / "home").write_text("a file")
        monkeypatch.setenv("HOME", str(shot.folder / "home"))
    kernels, close = {}, Host.close
    monkeypatch.setattr(Host, "close", lambda host: (kernels.update(host.kernels), close(host)))
    assert shot.run(to=["move"]).exit_code == 0
    ((_, message),) = shot.warned
    assert message.startswith("kernels are compiled for this run alone: ")
    assert not Path(kernels[TABLE]).parent.exists() and not (Path.cwd() / "~").exists()


def test_a_store_of_another_user_is_refused_unless_it_is_trusted(tmp_path, somebody_else, monkeypatch):
    with pytest.raises(BadInput, match=f"a store of user .*{TRUST}={tmp_path}"):
        check_store(tmp_path)
    monkeypatch.setenv(TRUST, f"/elsewhere:{tmp_path}")
    check_store(tmp_path)


def test_a_store_that_everybody_may_write_to_is_refused(tmp_path):
    check_store(tmp_path / "none")
    tmp_path.chmod(0o775)
    check_store(tmp_path)
    tmp_path.chmod(0o777)
    with pytest.raises(BadInput, match="everybody may write"):
        check_store(tmp_path)


def test_a_store_of_another_user_is_accepted_where_a_group_of_ours_may_write(tmp_path, somebody_else, monkeypatch):
    tmp_path.chmod(0o2775)
    check_store(tmp_path)
    tmp_path.chmod(0o2777)
    with pytest.raises(BadInput, match="everybody may write"):
        check_store(tmp_path)
    tmp_path.chmod(0o2775)
    monkeypatch.setattr(ownership.os, "getegid", lambda: 54321)
    monkeypatch.setattr(ownership.os, "getgroups", lambda: [54322])
    with pytest.raises(BadInput, match=r"a store of user .* to which no group of yours may write"):
        check_store(tmp_path)
