"""Trials pooled by scenario, figures over all scenarios, and the tables that show them."""

from __future__ import annotations

import dataclasses
import math
from collections.abc import Iterable, Sequence
from typing import Any

import numpy as np

from mecanum_base.accuracy.drift import Drift
from mecanum_base.accuracy.trial import METHODS, Trial

SLIPS = 0.01  # share of time with slip above 5 cm/s that makes a slip scenario
CHI2_95 = 5.991  # of 2 degrees of freedom
BAR_ORACLE, BAR_TWIST = 1.35, 4.5
WORSE = 1.5  # times the drift of another method that a single run may have
SLACK = 0.1  # % of distance: 5 mm in 5 m, with which nobody drives worse


@dataclasses.dataclass(frozen=True, slots=True)
class Errors:
    """One method in one scenario: ``drift`` % over 5 m (RMS), ``drift_median`` the median over
    seeds of each seed's RMS, ``ate`` m, ``final`` % of the path, ``yaw`` deg (RMS over seeds)."""

    drift: float | None
    drift_median: float | None
    ate: float
    final: float
    yaw: float


@dataclasses.dataclass(frozen=True, slots=True)
class ScenarioFigures:
    """One scenario: errors by method, consistency and slip figures of ours.

    ``nees_*`` are medians of 2 degrees of freedom (1.39 is ideal), ``coverage_*`` the shares
    within the 95 % ellipse; None where there was nothing to judge. ``nees_told`` is that of the
    position where the estimator was told how well the robots are built.
    """

    name: str
    seeds: int
    path: float
    slip_share: float
    errors: dict[str, Errors]
    nees_position: float | None
    nees_told: float | None
    nees_velocity: float | None
    coverage_position: float | None
    coverage_velocity: float | None
    f1: float | None
    latency: float | None
    missed_share: float | None
    false_per_hour: float
    diagonal: float | None
    runs: dict[int, dict[str, float | None]]  # seed: drift % over 5 m of that run by method

    @property
    def slips(self) -> bool:
        """Whether wheels slip in it."""
        return self.slip_share >= SLIPS

    def ratio(self, over: str, under: str, *, median: bool = False) -> float | None:
        """Drift of one method over that of another."""
        key = 'drift_median' if median else 'drift'
        a, b = (getattr(self.errors[m], key) for m in (over, under))
        return a / b if a is not None and b else None

    def worse(self, over: str, under: str) -> dict[int, float]:
        """Runs (seed: ratio) in which one method drifts :data:`WORSE` times as far as another,
        :data:`SLACK` of its drift aside."""
        found = {}
        for seed, drift in self.runs.items():
            a, b = drift[over], drift[under]
            if a is not None and b is not None and a > WORSE * b + SLACK:
                found[seed] = a / b if b else math.inf
        return found


def figures_of(trials: Sequence[Trial]) -> ScenarioFigures:
    """Pool the trials of one scenario."""
    slips = [t.slip for t in trials]
    hits, false, missed = (sum(getattr(s, key) for s in slips)
                           for key in ('hits', 'false_alarms', 'misses'))
    delays = [d for s in slips for d in s.delays]
    late = sum(s.missed_episodes for s in slips)
    both = sum(s.diagonal_all for s in slips)
    position = [v for t in trials for v in t.nees_position]
    velocity = [v for t in trials for v in t.nees_velocity]
    return ScenarioFigures(
        trials[0].scenario, len(trials), float(np.mean([t.path for t in trials])),
        sum(s.true_samples for s in slips) / sum(s.samples for s in slips),
        {method: _errors(trials, method) for method in METHODS},
        _median(position), _median([v for t in trials for v in t.nees_told]),
        _median(velocity), _within(position), _within(velocity),
        2 * hits / (2 * hits + false + missed) if hits + missed else None,
        _median(delays), late / (late + len(delays)) if late + len(delays) else None,
        sum(s.false_episodes for s in slips) / sum(s.hours for s in slips),
        sum(s.diagonal_right for s in slips) / both if both else None,
        {t.seed: {m: _drift(t.drift[m]) for m in METHODS} for t in trials})


def _errors(trials: Sequence[Trial], method: str) -> Errors:
    drifts = [t.drift[method] for t in trials]
    count = sum(d.segments for d in drifts)
    own = [v for d in drifts if (v := _drift(d)) is not None]
    return Errors(
        100.0 * math.sqrt(sum(d.segment_squares for d in drifts) / count) if count else None,
        _median(own),
        math.sqrt(sum(d.squares for d in drifts) / sum(d.samples for d in drifts)),
        100.0 * _rms(d.final_share for d in drifts),
        math.degrees(_rms(d.final_yaw for d in drifts)))


def _drift(drift: Drift) -> float | None:
    """RMS drift of one run, % over 5 m."""
    if not drift.segments:
        return None
    return 100.0 * math.sqrt(drift.segment_squares / drift.segments)


def overall(scenarios: Sequence[ScenarioFigures]) -> dict[str, Any]:
    """Figures over the slip scenarios (geometric means of ratios of drift), and all together."""
    slip = [s for s in scenarios if s.slips]
    calm = [s for s in scenarios if not s.slips]
    found: dict[str, Any] = {'slip_scenarios': [s.name for s in slip]}
    for title, median in (('', False), ('_median', True)):
        for name, over, under, among in (
                ('ours_over_oracle', 'ours', 'oracle', slip),
                ('ours_over_oracle_times', 'ours', 'oracle (times)', slip),
                ('ours_over_oracle_times_calm', 'ours', 'oracle (times)', calm),
                ('rl_over_ours', 'rl-style', 'ours', slip),
                ('ours_over_wheels_gyro', 'ours', 'wheels + gyro', scenarios)):
            values = [(r, s.name) for s in among
                      if (r := s.ratio(over, under, median=median)) is not None]
            ratios = [r for r, _ in values]
            found[name + title] = None if not values else {
                'geometric_mean': math.exp(float(np.mean(np.log(ratios)))),
                'least': min(values), 'most': max(values)}
    worse = [(ratio, s.name, seed) for s in scenarios
             for seed, ratio in s.worse('ours', 'wheels + gyro').items()]
    found['worse_than_wheels_gyro'] = {
        'runs': sum(len(s.runs) for s in scenarios), 'worse': sorted(worse, reverse=True)}
    return found


def _median(values: Sequence[float]) -> float | None:
    return float(np.median(values)) if len(values) else None


def _within(values: Sequence[float]) -> float | None:
    return float(np.mean(np.array(values) < CHI2_95)) if len(values) else None


def _rms(values: Iterable[float]) -> float:
    return math.sqrt(float(np.mean(np.square(list(values)))))
