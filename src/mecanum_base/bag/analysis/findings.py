"""Findings: what was seen, where in time, how bad it is, and what to do about it."""

from __future__ import annotations

from dataclasses import asdict, dataclass, field
from typing import Any

SEVERITIES = ('blocker', 'warning', 'note')


@dataclass(frozen=True, slots=True)
class Finding:
    """One finding.

    ``severity``: 'blocker' (results cannot be trusted), 'warning' (costs accuracy), 'note';
    ``code``: stable short name; ``title`` says what is wrong, ``evidence`` the numbers,
    ``advice`` what to do; ``spans``: (start, end) in seconds since the start of the recording;
    ``numbers``: the figures of the evidence by name, in SI units.
    """

    severity: str
    code: str
    title: str
    evidence: str
    advice: str
    topic: str = ''
    spans: tuple[tuple[float, float], ...] = ()
    numbers: dict[str, float] = field(default_factory=dict)

    def plain(self) -> dict[str, Any]:
        """As JSON values."""
        found = asdict(self)
        found['spans'] = [list(span) for span in self.spans]
        return found


def ordered(findings: list[Finding]) -> list[Finding]:
    """Worst first; among equals in the order of their time."""
    return sorted(findings, key=lambda f: (SEVERITIES.index(f.severity),
                                           f.spans[0][0] if f.spans else 0.0))


def spans_where(flag: Any, seconds: Any, shortest: float = 0.0) -> tuple[tuple[float, float], ...]:
    """Stretches (start, end) in seconds where ``flag`` (N,) holds, at least ``shortest`` long."""
    import numpy as np
    edges = np.flatnonzero(np.diff(np.concatenate(([0], np.asarray(flag, dtype=np.int8), [0]))))
    pairs = [(float(seconds[a]), float(seconds[b - 1])) for a, b in zip(edges[::2], edges[1::2])]
    return tuple(pair for pair in pairs if pair[1] - pair[0] >= shortest)
