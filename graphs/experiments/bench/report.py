"""The report of a benchmark: the machine, and tables of cases."""

from collections.abc import Callable
from typing import NamedTuple

from hairpipe.graphs.experiments.bench.machine import Machine, this_machine

Echo = Callable[[str], None]
"""Receives a line on the progress of a benchmark."""
Case = dict[str, str | int | float | None]
"""A measured case: values by column; the name of a column contains its unit."""


class Report(NamedTuple):
    """The result of a bench.

    module     of the bench
    tables     of cases, by name
    bandwidth  of memory, with all threads [GB/s]; None if it was not measured
    """

    module: str
    machine: Machine
    tables: dict[str, list[Case]]
    bandwidth: float | None = None


def make_report(module: str, tables: dict[str, list[Case]], bandwidth: float | None = None) -> Report:
    """Build the report of a benchmark on this machine, without empty tables."""
    return Report(module, this_machine(), {name: cases for name, cases in tables.items() if cases}, bandwidth)


def in_seconds(shares: dict[str, float], scale: float = 1.0, unit: str = "s") -> Case:
    """Return the times of parts [s] as columns, optionally in another unit; pure."""
    return {f"{part} [{unit}]": scale * seconds for part, seconds in shares.items()}
