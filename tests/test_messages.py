"""ROS field names are translated, not judged; wrong shapes are named."""

import math
from types import SimpleNamespace as Made

import numpy as np
import pytest

from mecanum_base import messages
from mecanum_base.core.records import Estimate, ImuSample, SlipEstimate, TickSample, WheelSample
from mecanum_base.messages import MalformedMessage

JOINTS = ('a', 'b', 'c')


def time(ns=0):
    return Made(sec=ns // 10**9, nanosec=ns % 10**9)


def header(ns=0, frame=''):
    return Made(stamp=time(ns), frame_id=frame)


def joint_state(name, position=(), velocity=(), ns=5):
    return Made(header=header(ns), name=list(name), position=list(position),
                velocity=list(velocity))


def vector(x=0.0, y=0.0, z=0.0):
    return Made(x=x, y=y, z=z)


def pose(x=0.0, y=0.0, yaw=0.0):
    return Made(position=vector(x, y),
                orientation=Made(x=0.0, y=0.0, z=math.sin(yaw / 2), w=math.cos(yaw / 2)))


def estimate(wheels=3):
    slip = SlipEstimate(np.arange(wheels) * 0.1, np.arange(wheels) * 0.2,
                        np.arange(wheels) * 0.3, 0.9, np.append(np.ones(wheels), math.nan),
                        np.array([0.1, 0.2, 0.3]), np.diag([1.0, 2.0, 3.0]))
    covariance = np.array([[1.0, 0.1, 0.2], [0.1, 2.0, 0.3], [0.2, 0.3, 3.0]])
    return Estimate(1_700_000_000_123_456_789, 'encoder', np.array([1.0, 2.0, 0.5]), covariance,
                    np.array([0.3, -0.4, 0.2]), 2 * covariance, slip)


# --- reading ------------------------------------------------------------------------------------

def test_wheels_are_found_by_name_in_any_order_among_foreign_joints():
    sample = messages.wheel_sample(
        joint_state(['arm', 'c', 'a', 'b'], [9.0, 3.0, 1.0, 2.0], [0.0, 30.0, 10.0, 20.0]), JOINTS)
    assert sample.position.tolist() == [1.0, 2.0, 3.0]
    assert sample.velocity.tolist() == [10.0, 20.0, 30.0]
    assert sample.stamp_ns == 5


def test_wheels_that_are_not_named_and_fields_that_are_empty_are_nan():
    sample = messages.wheel_sample(joint_state(['c', 'a'], [3.0, 1.0]), JOINTS)
    assert sample.position.tolist()[::2] == [1.0, 3.0] and math.isnan(sample.position[1])
    assert np.all(np.isnan(sample.velocity))


def test_a_message_without_wheels_is_none():
    assert messages.wheel_sample(joint_state(['arm'], [1.0]), JOINTS) is None


@pytest.mark.parametrize('msg,reason', [
    (joint_state(['a', 'a'], [1.0, 2.0]), 'joint named twice'),
    (joint_state(['a', 'b'], [1.0]), 'array length differs from name'),
    (joint_state(['a', 'b'], [1.0, 2.0], [1.0]), 'array length differs from name'),
    (joint_state(['a', 'b']), 'neither position nor velocity')])
def test_wrong_shapes_are_named(msg, reason):
    with pytest.raises(MalformedMessage, match=reason):
        messages.wheel_sample(msg, JOINTS)


def test_a_foreign_joint_named_twice_does_no_harm():
    sample = messages.wheel_sample(joint_state(['x', 'x', 'a'], [1.0, 2.0, 3.0]), JOINTS)
    assert sample.position[0] == 3.0


def test_ticks_keep_all_bits_and_their_length_is_checked():
    big = [2**62, -(2**62), 3]
    assert messages.tick_sample(Made(data=big), 3, 7).counts.tolist() == big
    with pytest.raises(MalformedMessage, match='length differs'):
        messages.tick_sample(Made(data=[1, 2]), 3, 7)


def imu(gyro_first=0.0, accel_first=0.0):
    return Made(header=header(11), angular_velocity=vector(0.1, 0.2, 0.3),
                linear_acceleration=vector(1.0, 2.0, 9.81),
                angular_velocity_covariance=[gyro_first] + [0.0] * 8,
                linear_acceleration_covariance=[accel_first] + [0.0] * 8)


def test_what_an_imu_says_it_has_not_is_nan():
    whole = messages.imu_sample(imu())
    assert whole.gyro.tolist() == [0.1, 0.2, 0.3] and whole.accel.tolist() == [1.0, 2.0, 9.81]
    assert np.all(np.isnan(messages.imu_sample(imu(accel_first=-1.0)).accel))
    assert np.all(np.isnan(messages.imu_sample(imu(gyro_first=-1.0)).gyro))


def test_a_given_pose_takes_its_own_axes_of_the_covariance():
    grid = np.arange(36.0).reshape(6, 6)
    msg = Made(header=header(3, '/odom'), pose=Made(pose=pose(1.0, 2.0, 0.5),
                                                    covariance=grid.ravel()))
    sample = messages.pose_sample(msg)
    assert sample.pose == pytest.approx([1.0, 2.0, 0.5], abs=1e-15)
    assert sample.covariance.tolist() == [[0.0, 1.0, 5.0], [6.0, 7.0, 11.0], [30.0, 31.0, 35.0]]
    assert sample.frame == 'odom'


def test_rates_of_an_array_follow_the_order_of_the_controller():
    assert messages.rates_of_array(Made(data=[1.0, 2.0, 3.0]), ('c', 'a', 'b'),
                                   JOINTS).tolist() == [2.0, 3.0, 1.0]
    with pytest.raises(MalformedMessage, match='2 entries instead of 3'):
        messages.rates_of_array(Made(data=[1.0, 2.0]), ('c', 'a', 'b'), JOINTS)


def test_scan_points_leave_out_what_hit_nothing():
    scan = Made(angle_min=0.0, angle_increment=math.pi / 2, range_min=0.5, range_max=5.0,
                ranges=[1.0, 0.1, 2.0, math.inf, math.nan, 6.0])
    assert messages.scan_points(scan) == pytest.approx(np.array([[1.0, 0.0], [-2.0, 0.0]]),
                                                       abs=1e-12)


def test_no_obstacles_are_an_empty_array():
    assert messages.obstacle_points(Made(poses=[])).shape == (0, 2)


# --- writing ------------------------------------------------------------------------------------

def odometry():
    return Made(header=header(), child_frame_id='', pose=Made(pose=pose(), covariance=None),
                twist=Made(twist=Made(linear=vector(), angular=vector()), covariance=None))


def test_an_estimate_becomes_odometry_that_reads_back():
    found = estimate()
    msg = messages.write_odometry(found, odometry(), 'odom', 'base_link')
    assert (msg.header.frame_id, msg.child_frame_id) == ('odom', 'base_link')
    assert messages.stamp_ns(msg.header.stamp) == found.stamp_ns
    assert messages.planar_pose(msg.pose.pose) == pytest.approx(found.pose, abs=1e-15)
    assert (msg.twist.twist.linear.x, msg.twist.twist.linear.y,
            msg.twist.twist.angular.z) == (0.3, -0.4, 0.2)
    grid = np.array(msg.pose.covariance).reshape(6, 6)
    axes = np.ix_([0, 1, 5], [0, 1, 5])
    assert np.array_equal(grid[axes], found.pose_covariance)
    assert np.array_equal(np.array(msg.twist.covariance).reshape(6, 6)[axes],
                          found.twist_covariance)
    rest = grid.copy()
    rest[axes] = 0.0
    assert np.array_equal(rest, np.diag([0.0, 0.0, 1e6, 1e6, 1e6, 0.0]))


def test_every_number_written_is_a_python_float():
    """rclpy publishes garbage for an int or a numpy scalar in a float field."""
    msg = messages.write_odometry(estimate(), odometry(), 'odom', 'base_link')
    position, turn, twist = msg.pose.pose.position, msg.pose.pose.orientation, msg.twist.twist
    values = [position.x, position.y, position.z, turn.x, turn.y, turn.z, turn.w, twist.linear.x,
              twist.linear.y, twist.linear.z, twist.angular.x, twist.angular.y, twist.angular.z]
    assert {type(v) for v in values} == {float}
    array = messages.write_slip_probability(estimate(), Made(data=None)).data
    assert array == [0.0, 0.3, 0.6, 0.9] and {type(v) for v in array} == {float}


def test_slip_has_wheels_first_and_the_body_last():
    ratio = messages.write_slip_ratio(estimate(), Made(data=None)).data
    assert ratio[:3] == [1.0] * 3 and math.isnan(ratio[3])
    msg = Made(header=header(), name=None, position=None, velocity=None)
    found = estimate()
    messages.write_slip_wheels(found.stamp_ns, found.slip.rate, found.slip.angle, msg, JOINTS)
    assert msg.name == list(JOINTS) and msg.velocity == [0.0, 0.1, 0.2]
    assert msg.position == [0.0, 0.2, 0.4]


def test_sensor_messages_read_back_as_the_samples_they_were_written_from():
    wheels = WheelSample(17, np.array([1.0, 2.0, 3.0]), np.array([4.0, 5.0, 6.0]))
    msg = Made(header=header(), name=[], position=[], velocity=[])
    back = messages.wheel_sample(messages.write_wheel_angles(wheels, msg, JOINTS), JOINTS)
    assert back.stamp_ns == 17 and np.array_equal(back.position, wheels.position)
    assert np.array_equal(back.velocity, wheels.velocity)
    ticks = TickSample(19, np.array([1, -2, 2**40]))
    assert np.array_equal(messages.tick_sample(messages.write_ticks(ticks, Made(data=[])), 3,
                                               19).counts, ticks.counts)
    sample = ImuSample(23, np.array([0.1, 0.2, 0.3]), np.array([1.0, 2.0, 9.8]))
    msg = imu()
    msg.orientation_covariance = None
    back = messages.imu_sample(messages.write_imu(sample, msg, 'imu_link'))
    assert back.stamp_ns == 23 and np.array_equal(back.gyro, sample.gyro)
    assert np.array_equal(back.accel, sample.accel)
    assert msg.orientation_covariance[0] == -1.0 and msg.header.frame_id == 'imu_link'


@pytest.mark.parametrize('stamp', [0, 1, 999_999_999, 10**9, 2**31 * 10**9 - 1])
def test_stamps_are_exact(stamp):
    assert messages.stamp_ns(messages.write_stamp(stamp, time())) == stamp


def test_diagnostics_have_a_byte_level_and_text_values():
    status = Made(name='n', level=2, message='m', values={'a': 1, 'b': 2.5}, hardware_id='h')
    array = messages.write_diagnostics(5, [status], Made(header=header(), status=None), Made, Made)
    item, = array.status
    assert (item.level, item.name, item.message, item.hardware_id) == (b'\x02', 'n', 'm', 'h')
    assert [(v.key, v.value) for v in item.values] == [('a', '1'), ('b', '2.5')]
