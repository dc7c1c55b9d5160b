"""Memory that was freed is used again without the kernel."""

import ctypes
import subprocess
import sys

import pytest

ROUNDS = """
import resource
from hairpipe.graph.run.malloc import keep_freed

{keep}
def faults():
    return resource.getrusage(resource.RUSAGE_SELF).ru_minflt

bytearray(1 << 26)
begun = faults()
for _ in range(5):
    bytearray(1 << 26)
print(faults() - begun)
"""


def faults(keep):
    program = ROUNDS.format(keep=keep)
    return int(subprocess.run([sys.executable, "-c", program], check=True, capture_output=True).stdout)


@pytest.mark.skipif(not hasattr(ctypes.CDLL(None), "mallopt"), reason="the C library has no mallopt")
def test_what_is_kept_does_not_come_from_the_kernel_again():
    assert faults("keep_freed()") < 100 < faults("")
