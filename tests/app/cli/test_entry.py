"""Starting up, finding commands, and saying what is wrong."""

import os
import re
import shlex
import subprocess
import sys
from pathlib import Path

import pytest

from hairpipe import __version__
from hairpipe.app.cli import options
from hairpipe.app.cli.completion import Bash
from hairpipe.app.cli.entry import CHECKOUT, COMMANDS, commands

from .conftest import START

HEAVY = ("numpy", "scipy", "numba", "pydantic", "rich", "h5py", "pxr")


def test_help_names_every_command(hairpipe):
    text = hairpipe("--help").stdout
    listed = re.findall(r"^  (\w+)  +(\S.*)$", text.partition("Commands:")[2], re.MULTILINE)
    assert [name for name, _ in listed] == list(COMMANDS)
    assert all(not summary.endswith("...") for _, summary in listed), "a summary is cut off"


@pytest.mark.parametrize("command", [*COMMANDS, "cache ls", "cache du", "cache verify", "cache gc", "usd check"])
def test_every_command_explains_itself(command, hairpipe):
    result = hairpipe(f"{command} --help")
    assert result.exit_code == 0 and result.stdout.startswith(f"Usage: hairpipe {command}")


def test_starting_up_imports_nothing_heavy():
    code = (
        "import click, sys\nfrom hairpipe.app.cli.entry import commands, COMMANDS\n"
        "for name in COMMANDS: commands.get_command(click.Context(commands), name)\n"
        f"print([name for name in {HEAVY} if name in sys.modules])"
    )
    assert subprocess.run([sys.executable, "-c", code], capture_output=True, text=True).stdout == "[]\n"


def test_unknown_commands_and_options_are_refused(hairpipe):
    for words, message in (("paln x.toml", "no command 'paln' (did you mean 'plan'?)"), ("--jsno", "--jsno")):
        result = hairpipe(words)
        assert result.exit_code == 2 and message in result.stderr


def test_version(hairpipe):
    assert hairpipe("--version").stdout == f"hairpipe {__version__}\n"


def test_system_errors_are_one_message(hairpipe, computed):
    result = hairpipe("get shot.toml list -o shot.toml/list.txt")
    assert (result.exit_code, result.stdout) == (2, "")
    assert result.stderr == "hairpipe: shot.toml: File exists\n" or "Not a directory" in result.stderr


@pytest.fixture
def wheel(monkeypatch):
    """Hide the experiments, which a wheel is without."""
    monkeypatch.setattr(options, "find_spec", lambda name: None)


@pytest.mark.usefixtures("wheel")
@pytest.mark.parametrize("words", [*CHECKOUT, "bench paper", "results --help", "run shot.toml --record"])
def test_a_wheel_says_what_commands_of_a_checkout_need(words, hairpipe, shot):
    result = hairpipe(words)
    assert (result.exit_code, result.stdout, result.stderr.count("\n")) == (2, "", 1)
    assert result.stderr.endswith("is not in a wheel (pip install -e . in a checkout)\n")


@pytest.mark.usefixtures("wheel")
def test_a_wheel_neither_lists_nor_completes_commands_of_a_checkout(hairpipe):
    result = hairpipe("--help")
    assert result.exit_code == 0 and "  trust " in result.stdout
    assert not [name for name in CHECKOUT if f"  {name} " in result.stdout]
    completion = Bash(commands, {}, "hairpipe", "_HAIRPIPE_COMPLETE")
    assert [item.value for item in completion.get_completions([], "wa")] == ["watch", "warm"]
    for name in CHECKOUT:
        assert {item.value for item in completion.get_completions([name], "")} == {*COMMANDS} - {*CHECKOUT}


def test_closed_output_ends_without_an_error():
    process = subprocess.Popen(
        [*START, "nodes", "--json"], stdout=subprocess.PIPE, stderr=subprocess.PIPE, env=os.environ
    )
    process.stdout.close()
    assert (process.stderr.read(), process.wait()) == (b"", 141)


def test_a_full_disk_under_the_output_is_one_message():
    with Path("/dev/full").open("w") as full:
        process = subprocess.run([*START, "nodes"], stdout=full, stderr=subprocess.PIPE, text=True)
    assert (process.returncode, process.stderr) == (2, "hairpipe: No space left on device\n")


def test_closed_error_stream_is_not_an_error(shot):
    """Nothing that is opened meanwhile takes the place of the stream for errors: workers write there."""
    command = shlex.join([*START, "run", "shot.toml", "-j1"])
    process = subprocess.run(f"{command} 2>&-", shell=True, stdout=subprocess.PIPE, text=True)
    assert process.returncode == 0 and "20 results computed" in process.stdout
    verified = subprocess.run([*START, "cache", "verify"], capture_output=True, text=True)
    assert verified.returncode == 0, "an error was written into a result"


def bash(*words: str, cwd=None) -> list[str]:
    """What bash is offered for the last of the words."""
    variables = {"_HAIRPIPE_COMPLETE": "bash_complete", "COMP_WORDS": "\n".join(["hairpipe", *words])}
    environment = os.environ | variables | {"COMP_CWORD": str(len(words))}
    process = subprocess.run(START, env=environment, capture_output=True, text=True, cwd=cwd)
    assert process.stderr == ""
    return [line.partition(",")[2] for line in process.stdout.splitlines() if line.startswith("plain")]


def complete(words: str, cwd=None) -> list[str]:
    return bash(*words.split(), cwd=cwd)


def test_the_shell_completes_commands_types_and_nodes(shot):
    assert complete("ru") == ["run"]
    assert complete("nodes make_bu") == ["make_bust"]
    assert complete("run shot.toml --to dr", shot.parent) == ["drawing"]
    assert complete("get shot.toml se", shot.parent) == ["seed"]
    assert complete("run none.toml --to dr", shot.parent) == []
    source = os.environ | {"_HAIRPIPE_COMPLETE": "bash_source"}
    assert "complete" in subprocess.run(START, env=source, capture_output=True, text=True).stdout


@pytest.mark.slow
def test_the_shell_completes_settings_values_and_outputs(shot):
    """bash takes = for a word of its own, and is offered what stands behind it."""
    assert bash("run", "demo", "--set", "h") == ["head.", "hair."]
    assert bash("run", "demo", "--set", "hair.scheme", "=", "tr") == ["tr_bdf2"]
    assert "network" in bash("run", "demo", "--set", "hair.model", "=")
    values = ["hair.stiction.reach=0.0005", "hair.stiction.release=0.0015"]
    assert bash("run", "demo", "--set", "hair.stiction.re") == values
    assert {"seed.value=1.0", "seed.bent.strength=1.0"} <= set(bash("run", "shot.toml", "--set", "se", cwd=shot.parent))
    assert bash("run", "shot.toml", "--set", "none.x", cwd=shot.parent) == []
    assert bash("get", "demo", "hair.s") == ["hair.strands", "hair.state"]
    assert bash("run", "paper/long_c") == ["paper/long_curly"]
    zsh = os.environ | {"_HAIRPIPE_COMPLETE": "zsh_complete", "COMP_CWORD": "4"}
    zsh["COMP_WORDS"] = "hairpipe run demo --set hair.scheme=tr"
    assert "hair.scheme=tr_bdf2" in subprocess.run(START, env=zsh, capture_output=True, text=True).stdout.split()


INTERRUPTED = """
import os, signal, sys
signal.signal(signal.SIGINT, signal.default_int_handler)
class Interrupt:
    def find_spec(self, name, path, target=None):
        if name == "{}":
            os.kill(os.getpid(), signal.SIGINT)
sys.meta_path.insert(0, Interrupt())
from hairpipe.cli import main
main()
"""


@pytest.mark.parametrize("name", ["click", "hairpipe.app.cli.commands.results", "pydantic"])
def test_ctrl_c_in_the_first_imports_is_one_line(name):
    command = [sys.executable, "-c", INTERRUPTED.format(name), "plan", "demo"]
    process = subprocess.run(command, capture_output=True, text=True)
    assert (process.returncode, process.stdout, process.stderr) == (130, "", "hairpipe: interrupted\n")
