"""What commands tell of the wiring: a full witness without a gyro, beside one a weak one.

The drive may be wired as wrongly as the encoders. Commands then say what the encoders say by the
robot file and prove nothing; only where they differ do they count, for the wiring that makes the
base do what it was asked for.
"""

from __future__ import annotations

from mecanum_base.bag.analysis.wiring_prices import PRICE
from mecanum_base.bag.analysis.wiring_signals import Signals
from mecanum_base.bag.analysis.wiring_target import Target
from mecanum_base.core.kinematics.matrix import wheels_from_body
from mecanum_base.core.kinematics.solve import body_from_wheels
from mecanum_base.core.kinematics.wheels import Wheels
from mecanum_base.core.parameter import FloatArray

_GAIN = 10.0  # asked for over driven by the wheels, at most and at least: motors, wrong counts
_UNLIKE = 2.5  # how much that may differ from axis to axis
_DISOBEYED = 2.0 * PRICE  # commands that fit no wiring: the drive has faults of its own
_PLAIN = 1.4  # motors may do that much more or less than they are asked for
_TOLD = 2.2  # log of 9 to 1

MOVES = 'a changed joint or sign moves the commands too: drive slowly at first'
ALIKE = 'motors and encoders are wired alike: the new line cures both'
ENCODERS = ('with the file as it is the base does what is asked of it: change the plugs or names '
            'of the encoders rather than this line, which moves the commands too')
APART = ('motors and encoders are not wired alike, commands do not tell which are wrong: change '
         'plugs or names rather than this line, which moves both')


class Commands:
    """Commands of one recording as targets; ``wheels`` of the robot file."""

    def __init__(self, signals: Signals, wheels: Wheels) -> None:
        asked = signals.asked
        self._asked = [] if asked is None else [Target(signals.wheel, c) for c in asked.T]
        self.as_read = min(self.fits(body_from_wheels(wheels_from_body(wheels))), _DISOBEYED)

    def fits(self, forward: FloatArray) -> float:
        """Cost of the commands if the base does ``forward`` (3, W) @ wheels; 0 without them."""
        return driven_cost(self._asked, forward)

    def cost(self, forward: FloatArray) -> float:
        """The same, or that of a drive that is wired like the encoders."""
        return min(self.fits(forward), self.as_read)


def driven_cost(asked: list[Target], forward: FloatArray) -> float:
    """Cost of commanded twists (vx, vy, w) if the base does ``forward`` (3, W) @ wheels, up to a
    gain, which is about the same for all axes; 0 without commands."""
    if not asked:
        return 0.0
    gain = driven_gain(asked, forward)
    return sum(target.cost(min(max(target.scale(row), gain / _UNLIKE), gain * _UNLIKE) * row)
               for target, row in zip(asked, forward))


def driven_gain(asked: list[Target], forward: FloatArray) -> float:
    """What was asked for over what the wheels did, along x and y."""
    level = [target.products(row) for target, row in zip(asked[:2], forward)]
    power = sum(p for _, p in level)
    gain = sum(c for c, _ in level) / power if power > 1e-12 else asked[2].scale(forward[2])
    return min(max(gain, 1.0 / _GAIN), _GAIN)


def gain_text(signals: Signals, forward: FloatArray) -> str:
    """Wheels that do another speed than was asked for, where nothing else tells of scales; empty
    if they do what they should."""
    if not signals.commanded or signals.witness is None:
        return ''
    gain = driven_gain([Target(signals.wheel, c) for c in signals.witness.T], forward)
    if 1.0 / _PLAIN < gain < _PLAIN:
        return ''
    return (f'the wheels, as the robot file reads them, do {1.0 / gain:.2f} times what was asked '
            'for: wrong counts or radius, or motors that do another speed; measure a drive of 2 m')


def caution(signals: Signals, wheels: Wheels, forward: FloatArray) -> str:
    """Whether changing names or signs in the robot file would spoil the commands; ``forward``
    (3, W) of the right wiring."""
    if signals.asked is None:
        return APART if signals.commanded else MOVES
    commands = Commands(signals, wheels)
    better = commands.fits(forward) - commands.as_read
    return ENCODERS if better < -_TOLD else ALIKE if better > _TOLD else MOVES
