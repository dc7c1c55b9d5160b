"""The scripts of the page are typed, by their comments."""

import shutil
import subprocess

import pytest

from hairpipe.app.page.assets import WEB

COMPILER = ("npm", "exec", "--yes", "--package=typescript@5.9.3", "--", "tsc")


@pytest.mark.slow
def test_the_scripts_of_the_page_have_types():
    if not shutil.which("npm") or subprocess.run([*COMPILER, "--version"], capture_output=True).returncode:
        pytest.skip("no npm, or no registry of its packages, to check the types of scripts with")
    found = subprocess.run([*COMPILER, "-p", str(WEB / "jsconfig.json")], capture_output=True, text=True)
    assert found.returncode == 0, found.stdout
