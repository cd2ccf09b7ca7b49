"""Drive to a goal as in a potential field, heading independent of the path (D eq. 21-23, rebuilt).

    d = |goal - p|,  theta_g = bearing of the goal in the world,  theta = yaw of the base
    v(d) = v_max             d > K_r
         = v_max d / K_r     K_stop < d <= K_r
         = 0                 d <= K_stop
    vx = v cos(theta_g - theta)      D21      vy = v sin(theta_g - theta)      D22
    w  = w_max sin(theta_ref - theta)         D23

Closed loop (K_stop = 0): d falls linearly, then as K_r exp(-v_max t / K_r), on a straight line;
the heading error as tan(e/2) = tan(e0/2) exp(-w_max t), with an unstable equilibrium at e = pi.

Feed-forward adds the velocity of a moving goal. Without it the base lags: tau = K_r / v_max, on a
circle (R, Om) it runs at radius R / sqrt(1 + (Om tau)^2), at distance R Om tau / sqrt(1 + (Om
tau)^2), and its heading lags by asin(spin / w_max).

Obstacles are OUR EXTENSION (the source names a repulsion and gives no law). Each point closer than
the influence radius r_i repels with speed gain v_max (r_i - rho)/(r_i - r_k), full gain at the
keep-out radius r_k; the sum is capped at v_max. Then the speed towards each point is limited to
v_max (rho - r_k)/(r_i - r_k), so that the keep-out circle is approached but never entered. As in
every potential field, obstacles that together enclose the goal leave places where the base stands.
"""

from __future__ import annotations

import math

import numpy as np

from mecanum_base.core import se2
from mecanum_base.core.command.goal import GoalConfig
from mecanum_base.core.parameter import FloatArray

_PASSES = 20  # sweeps over the keep-out limits; afterwards what still breaks one is stopped


class GoalField:
    """The control law with the settings of block ``goal``; holds no state between calls."""

    def __init__(self, config: GoalConfig) -> None:
        self.config = config

    def speed(self, distance: float) -> float:
        """v(d) [m/s] at the distance d m from the goal (D21, D22)."""
        config = self.config
        if distance <= config.stop_radius:
            return 0.0
        if distance <= config.slow_radius:
            return config.max_speed * distance / config.slow_radius
        return config.max_speed

    def yaw_rate(self, heading_error: float) -> float:
        """w [rad/s] from theta_ref - theta rad (D23)."""
        return self.config.max_yaw_rate * math.sin(heading_error)  # D23

    def twist(self, pose: FloatArray, goal: FloatArray, theta_ref: float,
              feed_forward: FloatArray | None = None,
              obstacles: FloatArray | None = None) -> FloatArray:
        """Commanded twist (3,) in base axes.

        ``pose`` (3,) of the base, ``goal`` (2,) or longer (x, y m), ``theta_ref`` rad wanted
        heading, ``feed_forward`` (3,) velocity of the goal (x', y' m/s, yaw' rad/s),
        ``obstacles`` (N, 2) points m: all in one world frame. ``feed_forward`` is added whenever
        it is given; the keep-out limits hold for the sum.
        """
        gap = np.asarray(goal, dtype=np.float64)[:2] - pose[:2]
        distance = math.hypot(gap[0], gap[1])
        velocity = np.zeros(2)
        if distance > 0.0:
            velocity = self.speed(distance) / distance * gap  # D21, D22 in world axes
        turn = self.yaw_rate(theta_ref - float(pose[2]))
        if feed_forward is not None:
            velocity = velocity + feed_forward[:2]
            turn += float(feed_forward[2])
        if obstacles is not None and len(obstacles):
            velocity = self._avoid(velocity, pose[:2], np.asarray(obstacles, dtype=np.float64))
        planar = se2.rotation(-float(pose[2])) @ velocity  # D18: world -> base axes
        return np.array([planar[0], planar[1], turn])

    def reached(self, pose: FloatArray, goal: FloatArray, theta_ref: float) -> bool:
        """Within ``position_tolerance`` (never below ``stop_radius``) and ``yaw_tolerance``."""
        config = self.config
        distance = math.hypot(float(goal[0] - pose[0]), float(goal[1] - pose[1]))
        error = abs(se2.wrap_angle(theta_ref - float(pose[2])))
        return (distance <= max(config.position_tolerance, config.stop_radius)
                and error <= config.yaw_tolerance)

    def _avoid(self, velocity: FloatArray, place: FloatArray, points: FloatArray) -> FloatArray:
        """World velocity (2,) after repulsion and keep-out limits of ``points`` (N, 2)."""
        config = self.config
        away = place - points
        range_ = np.hypot(away[:, 0], away[:, 1])
        near = range_ < config.influence_radius
        if not np.any(near):
            return velocity
        order = np.argsort(range_[near])
        range_ = range_[near][order]
        away = away[near][order] / np.maximum(range_, 1e-9)[:, None]
        depth = config.influence_radius - config.keep_out_radius
        push = config.repulsion * config.max_speed * (config.influence_radius - range_) / depth
        velocity = velocity + push @ away
        size = math.hypot(velocity[0], velocity[1])
        velocity = velocity * min(1.0, config.max_speed / size) if size > 0.0 else velocity
        # speed towards point i at most allowed_i; inside the keep-out circle: outwards
        allowed = config.max_speed * (range_ - config.keep_out_radius) / depth
        return _limit_approach(velocity, away, allowed)


def _limit_approach(velocity: FloatArray, away: FloatArray, allowed: FloatArray) -> FloatArray:
    """Velocity (2,) near the given one with -velocity . away_i <= allowed_i for all i."""
    for _ in range(_PASSES):
        excess = -(away @ velocity) - allowed
        worst = int(np.argmax(excess))
        if excess[worst] <= 1e-12:
            return velocity
        velocity = velocity + excess[worst] * away[worst]
    if np.all(allowed >= 0.0):
        excess = -(away @ velocity)
        share = np.where(excess > allowed, allowed / np.maximum(excess, 1e-12), 1.0)
        return velocity * float(np.min(share))
    return velocity
