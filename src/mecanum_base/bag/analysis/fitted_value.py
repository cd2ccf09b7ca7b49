"""A constant with its interval, or the reason why it is not given."""

from __future__ import annotations

from dataclasses import dataclass

LEVEL = 0.9  # probability with which an interval covers the truth


@dataclass(frozen=True, slots=True)
class Value:
    """One constant: ``low`` to ``high`` covers it with 90 %; ``verdict``: why (not) given."""

    name: str
    value: float | None
    low: float | None
    high: float | None
    verdict: str

    @property
    def given(self) -> bool:
        """Whether there is a value."""
        return self.value is not None


def refused(name: str, why: str) -> Value:
    """A constant that is not given."""
    return Value(name, None, None, None, why)
