"""What a base cannot know about its own slip, in plain words."""

from __future__ import annotations

import numpy as np

from mecanum_base.core.estimation.geometry import Base, rolling_rows


def unobservable(base: Base) -> tuple[str, ...]:
    """Sentences on slip that no estimate can show for this base, whatever its sensors."""
    notes = ['constant common slip (all wheels alike, at constant speed) cannot be seen by any '
             'combination of encoders and IMU']
    spare = base.count - int(np.linalg.matrix_rank(rolling_rows(base)))
    if spare == 0:
        notes.append(f'{base.count} wheels leave no redundancy: without an IMU slip cannot be '
                     'seen at all')
    elif spare == 1:
        notes.append(f'{base.count} wheels leave one redundant equation: without an IMU slip can '
                     'be noticed but not placed on a wheel')
    return tuple(notes)
