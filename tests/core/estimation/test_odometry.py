"""Dead reckoning by the wheels alone, against ways worked out by hand."""

import math

import numpy as np
import pytest
from staged_drive import LEVER, RADIUS, RECTANGLE, frames, rectangle, staged, wheel_angles

from mecanum_base.core.estimation.odometry import WheelOdometry
from mecanum_base.core.estimation.sensors import EncoderConfig
from mecanum_base.core.platform.carriers import Carriers
from mecanum_base.core.records import WheelSample

MS = 1_000_000
ENCODER = EncoderConfig(counts_per_revolution=4096.0)
FL, FR, RL, RR = range(4)


def reading(stamp_ms, angle):
    return WheelSample(stamp_ms * MS, np.array(angle, dtype=float), np.full(len(angle), math.nan))


def rolled(*steps, base=None, seconds=1.0, parts=20):
    """Pose after wheel-angle steps (W,) rad, each rolled evenly in ``parts`` readings."""
    subject = WheelOdometry(base or rectangle(), ENCODER)
    angle, at = np.zeros(len(steps[0])), 0
    subject.handle(reading(0, angle))
    for step in steps:
        for _ in range(parts):
            angle = angle + np.array(step, dtype=float) / parts
            at += round(1000 * seconds / parts)
            subject.handle(reading(at, angle))
    return subject


def test_one_radian_of_all_wheels_is_one_radius_ahead():
    assert rolled([1, 1, 1, 1]).pose == pytest.approx([RADIUS, 0.0, 0.0], abs=1e-15)


def test_diagonals_against_each_other_are_a_strafe_to_the_left():
    assert rolled([-1, 1, 1, -1]).pose == pytest.approx([0.0, RADIUS, 0.0], abs=1e-15)


def test_sides_against_each_other_are_a_spin_to_the_left():
    # L = 0.35 m: one radian of the wheels turns the base by r/L
    assert rolled([-1, 1, -1, 1]).pose == pytest.approx([0.0, 0.0, RADIUS / LEVER], abs=1e-15)


def test_a_square_of_four_strafes_and_drives_closes():
    ahead, left = np.ones(4) * 20.0, np.array([-1, 1, 1, -1]) * 20.0
    half = rolled(ahead, left)
    assert half.pose == pytest.approx([1.0, 1.0, 0.0], abs=1e-12)
    assert rolled(ahead, left, -ahead, -left).pose == pytest.approx(np.zeros(3), abs=1e-12)


def test_a_square_with_quarter_turns_closes_after_a_whole_turn():
    ahead = np.ones(4) * 20.0
    turn = np.array([-1, 1, -1, 1]) * (math.pi / 2) * LEVER / RADIUS
    assert rolled(*[ahead, turn] * 4).pose == pytest.approx([0, 0, 2 * math.pi], abs=1e-12)


def test_an_arc_is_exact_however_coarse_the_readings_are():
    # pi/2 to the left on a circle of 1 m: vx = pi/2, wz = pi/2
    step = RECTANGLE @ np.array([math.pi / 2, 0.0, math.pi / 2])
    # 25 rad in one step of 1 s is below three times the top speed of 40 rad/s
    assert rolled(step, parts=1).pose == pytest.approx([1.0, 1.0, math.pi / 2], abs=1e-12)


def test_the_twist_is_the_way_of_the_last_reading_by_its_time():
    assert rolled([8, 8, 8, 8], seconds=2.0).twist == pytest.approx([0.2, 0.0, 0.0], abs=1e-12)


def test_one_wheel_alone_counts_a_quarter_of_its_way():
    # least squares of four rows: a lone FL drives x by r/4, y by -r/4, yaw by -r/(4 L)
    subject = rolled([1, 0, 0, 0], parts=1)
    turn = -RADIUS / (4 * LEVER)
    assert subject.twist == pytest.approx([RADIUS / 4, -RADIUS / 4, turn], abs=1e-15)


def test_a_yaw_step_of_the_gyro_replaces_that_of_the_wheels():
    subject = WheelOdometry(rectangle(), ENCODER)
    subject.handle(reading(0, [0, 0, 0, 0]))
    subject.handle(reading(10, [-0.1, 0.1, -0.1, 0.1]), yaw_increment=0.25)
    assert subject.pose == pytest.approx([0.0, 0.0, 0.25], abs=1e-15)


def test_three_of_four_wheels_still_tell_the_motion():
    subject = WheelOdometry(rectangle(), ENCODER)
    subject.handle(reading(0, [0, 0, 0, 0]))
    subject.handle(reading(10, [0.1, 0.1, 0.1, math.nan]))
    assert subject.pose == pytest.approx([0.1 * RADIUS, 0.0, 0.0], abs=1e-15)


def test_two_wheels_tell_nothing_and_are_made_up_for_by_the_next_whole_reading():
    subject = WheelOdometry(rectangle(), ENCODER)
    subject.handle(reading(0, [0, 0, 0, 0]))
    subject.handle(reading(10, [math.nan, 0.0, math.nan, 0.0]))
    assert subject.pose.tolist() == [0.0, 0.0, 0.0]


def test_readings_that_cannot_be_used_leave_the_pose_alone():
    subject = WheelOdometry(rectangle(), ENCODER)
    subject.handle(reading(10, [0, 0, 0, 0]))
    subject.handle(reading(20, [0.1] * 4))
    before = subject.pose.copy()
    subject.handle(reading(20, [0.3] * 4))
    subject.handle(reading(5, [0.3] * 4))
    subject.handle(reading(30, [math.nan] * 4))
    assert subject.pose.tolist() == before.tolist()


@pytest.mark.parametrize('twist', [(0.5, 0, 0), (0, 0.4, 0), (0, 0, 1.5), (0.4, -0.3, 1.0)])
def test_a_driven_way_is_found_again(twist):
    motion = staged((2, twist), (1, (0, 0, 0)))
    subject = WheelOdometry(rectangle(), ENCODER)
    for frame in frames(motion, wheel_angles(motion), quantised=False):
        subject.handle(frame)
    # constant twist within 10 ms: ramps leave some 1e-6 m
    assert subject.pose == pytest.approx(motion.pose[-1], abs=1e-5)


def carriers():
    return Carriers(name=('front', 'rear'), x=[0.3, -0.3], y=[0.0, 0.0],
                    axle_offset=[-0.1, -0.1], half_track=[0.12, 0.12], wheel_radius=[0.05, 0.05],
                    left_joint=('a', 'c'), right_joint=('b', 'd'), max_speed=[40.0, 40.0])


def carrier_drive(twist, seconds):
    """Wheel angles (N, 4) at 1 kHz of the platform under a constant twist, by the closed form.

    The velocity of hinge i, seen along and across its carrier at the angle t_i from the platform,
    is (f, s). The axle midpoint lies e behind: it cannot slide sideways, so the carrier turns at
    W = -s/e against the floor, and its wheels roll with f -+ b W (left, right).
    """
    vx, vy, wz = twist
    hinge, angle, dt = np.zeros(2), np.zeros((round(seconds * 1000) + 1, 4)), 1e-3
    for k in range(1, len(angle)):
        middle = hinge.copy()
        for _ in range(3):  # midpoint rule by iteration
            rate, wheels = np.zeros(2), np.zeros(4)
            for i, x in enumerate((0.3, -0.3)):
                ux, uy = vx, vy + wz * x
                f = math.cos(middle[i]) * ux + math.sin(middle[i]) * uy
                s = -math.sin(middle[i]) * ux + math.cos(middle[i]) * uy
                turn = -s / -0.1
                rate[i] = turn - wz
                wheels[2 * i:2 * i + 2] = (f - 0.12 * turn) / 0.05, (f + 0.12 * turn) / 0.05
            middle = hinge + 0.5 * dt * rate
        hinge = hinge + dt * rate
        angle[k] = angle[k - 1] + dt * wheels
    return angle, hinge


@pytest.mark.parametrize(('twist', 'steered'), [
    ((0.3, 0.0, 0.0), (0.0, 0.0)),
    # a strafe turns both carriers into the direction of travel, tan(t/2) = exp(-v t/|e|) law
    ((0.0, 0.3, 0.0), (2 * math.atan(math.tanh(3.0)), 2 * math.atan(math.tanh(3.0)))),
])
def test_the_carrier_drive_of_these_tests_steers_as_the_tractrix_does(twist, steered):
    _, hinge = carrier_drive(twist, 2.0)
    # t' = (v/|e|) cos t has the solution tan(t/2) = tanh(v T/(2 |e|)); 0.3*2/0.2 = 3
    assert hinge == pytest.approx(steered, abs=1e-4)


@pytest.mark.parametrize('twist', [(0.3, 0, 0), (0.2, 0.1, 0), (0.2, 0.0, 0.3), (0.0, 0.3, 0.0)])
def test_a_platform_on_two_carriers_goes_where_the_closed_form_says(twist):
    angle, _ = carrier_drive(twist, 2.0)
    subject = WheelOdometry(carriers(), ENCODER)
    for k in range(0, len(angle), 5):
        subject.handle(reading(k, angle[k]))
    vx, vy, wz = twist
    yaw = wz * 2.0
    along = math.sin(yaw) / wz if wz else 2.0
    across = (1.0 - math.cos(yaw)) / wz if wz else 0.0
    end = [along * vx - across * vy, across * vx + along * vy, yaw]
    # hinge angles are held over a reading (5 ms): first order, about 2 % of the steering way
    assert subject.pose[:2] == pytest.approx(end[:2], abs=0.012)
    assert subject.pose[2] == pytest.approx(end[2], abs=0.02)
