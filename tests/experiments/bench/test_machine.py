"""The description of this machine."""

import platform

import pytest

from hairpipe.graphs.experiments.bench import machine

CPUINFO = """processor	: 0
vendor_id	: AuthenticAMD
cpu family	: 25
model		: 17
model name	: AMD EPYC

processor	: 1
cpu family	: 26
model		: 2
model name	: another
"""


@pytest.mark.parametrize(
    ("text", "name"),
    [
        (CPUINFO, "AMD EPYC family 25 model 17"),
        ("model name	: Some Processor\n", "Some Processor"),
        ("", platform.processor() or platform.machine()),
    ],
)
def test_a_processor_is_named_with_its_generation(text, name, monkeypatch, tmp_path):
    (tmp_path / "cpuinfo").write_text(text)
    monkeypatch.setattr(machine, "Path", lambda path: tmp_path / "cpuinfo")
    assert machine.this_machine().processor == name
