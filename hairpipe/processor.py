"""The class of processors whose results are equal to the bit, and the environment that keeps a process to it.

numpy and its linear algebra choose by the processor between functions whose last bits differ: exp, arctan, power and
others with AVX-512 and without. So processes that compute use only what every processor of a class has. Kernels need no
such limit: numba compiles for the processor at hand, but computes in the order that is written and fuses nothing.

Equal are results of one class, operating system and C library (exp, sin and so on of kernels are those of the C
library). Processors other than x86-64 are a class by the name of their architecture, which we have not tried.
"""

import os
import platform
from collections.abc import Iterable
from functools import cache
from pathlib import Path

V3 = frozenset(["abm", "avx", "avx2", "bmi1", "bmi2", "f16c", "fma", "movbe"])
"""Features of x86-64-v3 that x86-64-v2 does not have, as named by Linux."""
_AVX512 = "AVX512F AVX512CD AVX512_KNL AVX512_KNM AVX512_SKX AVX512_CLX AVX512_CNL AVX512_ICL AVX512_SPR X86_V4"
_AVX = "AVX F16C FMA3 AVX2 X86_V3"
SETTINGS = {
    "x86-64-v3": {"NPY_DISABLE_CPU_FEATURES": _AVX512, "OPENBLAS_CORETYPE": "Haswell"},
    "x86-64": {"NPY_DISABLE_CPU_FEATURES": f"{_AVX} {_AVX512}", "OPENBLAS_CORETYPE": "Prescott"},
}
"""Environment by class. Names of features are those of numpy 1.26 and 2, which each ignore those of the other."""
ALWAYS = {"NUMBA_DISABLE_INTEL_SVML": "1"}
"""Environment of every class: numba would use Intel's vector functions where they are installed."""
ENABLED = "NPY_ENABLE_CPU_FEATURES"
"""Setting of numpy that excludes the other one."""


def processor_class() -> str:
    """Name the class of this processor, and settings of the environment that replace those of the class."""
    name = class_of(platform.machine(), processor_flags())
    own = {**ALWAYS, **SETTINGS.get(name, {}), ENABLED: ""}
    forced = [f"{key}={os.environ[key]}" for key in own if os.environ.get(key, own[key]) != own[key]]
    return ", ".join([name, *forced])


def class_settings() -> dict[str, str]:
    """Environment variables that keep a process to the class of this processor; those that are set stay as they are."""
    own = ALWAYS | SETTINGS.get(class_of(platform.machine(), processor_flags()), {})
    if os.environ.get(ENABLED):
        own.pop("NPY_DISABLE_CPU_FEATURES", None)
    return {key: os.environ.get(key, value) for key, value in own.items()}


def class_of(machine: str, flags: Iterable[str]) -> str:
    """Name the class of a processor of this architecture with these features, as Linux names them; pure."""
    if machine.lower() not in ("x86_64", "amd64"):
        return machine
    return "x86-64-v3" if V3.issubset(flags) else "x86-64"


@cache
def processor_flags() -> frozenset[str]:
    """Features of the processor as Linux lists them; none on other systems."""
    try:
        lines = Path("/proc/cpuinfo").read_text(encoding="utf-8").splitlines()
    except OSError:
        return frozenset()
    return frozenset(next((line.partition(":")[2] for line in lines if line.startswith("flags")), "").split())
