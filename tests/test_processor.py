"""The class of the processor: results of one class are equal to the bit, those of another are no hits."""

import json
import subprocess
from pathlib import Path

import pytest

import hairpipe
from hairpipe.child import command
from hairpipe.engine.hosts.host import environment
from hairpipe.processor import SETTINGS, class_of, class_settings, processor_class, processor_flags

DISABLED, ENABLED = "NPY_DISABLE_CPU_FEATURES", "NPY_ENABLE_CPU_FEATURES"
MODERN = "fpu sse4_2 avx f16c avx2 bmi1 bmi2 fma movbe abm"
HEAD = """schema = 1
frames = [1, 1]
fps = 24
[head]
type = "make_bust"
[groom]
type = "grow_groom"
in.scalp = "head"
strands = 60
segments = 16
"""


@pytest.fixture(autouse=True)
def free(monkeypatch):
    """Leave the choice to us: nothing in the environment forces another one."""
    for name in (*SETTINGS["x86-64-v3"], "NUMBA_DISABLE_INTEL_SVML", ENABLED):
        monkeypatch.delenv(name, raising=False)


@pytest.mark.parametrize(
    ("machine", "flags", "name"),
    [
        ("x86_64", MODERN, "x86-64-v3"),
        ("x86_64", f"{MODERN} avx512f avx512vl", "x86-64-v3"),
        ("AMD64", MODERN.replace("fma", ""), "x86-64"),
        ("x86_64", "", "x86-64"),
        ("aarch64", "fp asimd sve", "aarch64"),
    ],
)
def test_a_class_is_what_its_processors_have_in_common(machine, flags, name):
    assert class_of(machine, flags.split()) == name


def test_forced_features_are_part_of_the_class(monkeypatch):
    before = processor_class()
    monkeypatch.setenv("OPENBLAS_CORETYPE", "Zen")
    assert class_settings()["OPENBLAS_CORETYPE"] == "Zen"
    assert processor_class() == f"{before}, OPENBLAS_CORETYPE=Zen"
    monkeypatch.setenv(ENABLED, "AVX2")  # numpy refuses both at a time
    assert DISABLED not in class_settings() and processor_class().endswith(f"{ENABLED}=AVX2")


def test_a_process_kept_to_a_class_is_of_that_class_itself(monkeypatch):
    before = processor_class()
    for name, value in class_settings().items():
        monkeypatch.setenv(name, value)
    assert processor_class() == before


def test_workers_compute_without_what_other_processors_of_the_class_lack():
    code = "import json, numpy; core = (getattr(numpy, '_core', None) or numpy.core)._multiarray_umath; "
    code += "print(json.dumps([name for name in core.__cpu_dispatch__ if core.__cpu_features__[name]]))"
    done = subprocess.run(command(code), env=environment(1, {}), check=True, capture_output=True)
    assert not [name for name in json.loads(done.stdout) if name.startswith(("AVX512", "X86_V4"))]


def test_head_and_groom_are_equal_whatever_the_processor_has_beyond_the_class(tmp_path, monkeypatch):
    if "avx512f" not in processor_flags():
        pytest.skip("a processor without AVX-512: there is nothing to leave out")
    graph = Path(tmp_path, "shot.toml")
    graph.write_text(HEAD)
    digests = []
    for store, left_out in (("plain", None), ("limited", SETTINGS["x86-64-v3"][DISABLED])):
        if left_out is not None:
            monkeypatch.setenv(DISABLED, left_out)
        shot = hairpipe.load(str(graph), cache=tmp_path / store)
        shot.run()
        digests.append({str(task): record.outputs for task, record in shot.plan().records.items()})
    assert digests[0] == digests[1] and len(digests[0]) == 2
