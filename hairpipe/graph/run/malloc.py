"""What a process does with memory that nodes free."""

import ctypes

_M_TRIM_THRESHOLD, _M_MMAP_MAX = -1, -4
"""Of mallopt(3)."""


def keep_freed() -> None:
    """Let this process keep memory that is freed for whoever asks next, where its C library is glibc.

    A step of much hair asks for and frees its arrays by the hundred. Large ones would come from the kernel each time,
    which sets all of them to zero first.
    """
    mallopt = getattr(ctypes.CDLL(None), "mallopt", None)
    if mallopt is not None:
        mallopt(_M_MMAP_MAX, 0)
        mallopt(_M_TRIM_THRESHOLD, -1)
