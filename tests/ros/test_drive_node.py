"""The drive node in stepped time: topics, types, order, signs, limits, clocks, diagnostics."""

import math

import numpy as np
import pytest
from geometry_msgs.msg import Twist, TwistStamped, Vector3
from rclpy.clock_type import ClockType
from rclpy.qos import QoSProfile, ReliabilityPolicy
from sensor_msgs.msg import JointState
from std_msgs.msg import Float64MultiArray
from std_srvs.srv import SetBool

from mecanum_base import robot_file
from mecanum_base.ros.drive_node import DriveNode
from mecanum_base.ros.scripted import Script, parameter

STEP = 0.02
CARRIERS = {
    'carriers': {
        'name': ['front', 'rear'], 'x': [0.3, -0.3], 'y': [0.0, 0.0], 'axle_offset': [-0.1, -0.1],
        'half_track': [0.12, 0.12], 'wheel_radius': [0.05, 0.05],
        'left_joint': ['front_left', 'rear_left'], 'right_joint': ['front_right', 'rear_right'],
        'hinge_joint': ['front_hinge', 'rear_hinge'], 'max_speed': [20.0, 20.0]},
    'encoder': {'counts_per_revolution': 4096.0}}


class Stage:
    """A drive node on a script, with ears on its topics."""

    def __init__(self, script, robot, message=Twist, wheels=JointState, qos=10, **parameters):
        self.script = script
        self.steer = script.publisher(message, 'cmd_vel', qos)
        self.node = script.add(DriveNode, robot=robot, parameters={
            name.replace('__', '.'): value for name, value in parameters.items()})
        self.wheels = script.listen(wheels, 'wheel_commands')
        self.limited = script.listen(TwistStamped, 'cmd_vel_limited')
        self.message = message
        script.connect()

    def command(self, x=0.0, y=0.0, yaw=0.0, **more):
        message = self.message()
        twist = getattr(message, 'twist', message)
        twist.linear.x, twist.linear.y, twist.angular.z = float(x), float(y), float(yaw)
        for name, value in more.items():
            part, axis = name.split('_')
            setattr(getattr(twist, part), axis, value)
        self.script.publish(self.steer, message)

    def drive(self, seconds, *twist):
        """Send the command at 10 Hz while time runs."""
        for _ in range(round(seconds / 0.1)):
            self.command(*twist)
            self.script.run(0.1, STEP)

    def rates(self):
        message = self.wheels[-1]
        return list(message.data if isinstance(message, Float64MultiArray) else message.velocity)

    def twist(self):
        last = self.limited[-1].twist
        return [last.linear.x, last.linear.y, last.angular.z]

    def status(self, name):
        found = {s.name: s for s in self.node._diagnostics.publish()}
        return found[f'drive_node: {name}']


@pytest.fixture
def script():
    with Script() as made:
        yield made


def test_idle_wheels_get_zeros_at_the_rate_of_the_node(script, robot_path):
    stage = Stage(script, robot_path)
    stage.wheels.clear()
    stage.limited.clear()
    script.run(1.0, STEP)
    assert len(stage.wheels) == len(stage.limited) == 50
    assert stage.rates() == [0.0] * 4 and stage.twist() == [0.0] * 3
    assert stage.limited[-1].header.frame_id == 'base_link'
    stamps = [m.header.stamp.sec * 10**9 + m.header.stamp.nanosec for m in stage.wheels]
    assert set(np.diff(stamps)) == {20_000_000} and stamps[-1] == script.now_ns


def test_a_command_moves_the_wheels_named_in_the_robot_file(script, robot_path):
    stage = Stage(script, robot_path)
    stage.drive(1.0, 0.5)
    assert list(stage.wheels[-1].name) == [
        'front_left_wheel_joint', 'front_right_wheel_joint', 'rear_left_wheel_joint',
        'rear_right_wheel_joint']
    assert stage.rates() == pytest.approx([10.0] * 4)
    assert stage.twist() == pytest.approx([0.5, 0.0, 0.0])


def test_yaw_and_strafe_turn_the_wheels_as_the_reference_frame_says(script, robot_path):
    stage = Stage(script, robot_path)
    stage.drive(1.0, 0.0, 0.3, 0.0)
    front_left, front_right, rear_left, rear_right = np.sign(stage.rates())
    assert (front_left, front_right, rear_left, rear_right) == (-1, 1, 1, -1)  # to the left
    stage.drive(1.5, 0.0, 0.0, 0.5)
    assert list(np.sign(stage.rates())) == [-1, 1, -1, 1]  # counter-clockwise


def test_what_is_told_is_on_cmd_vel_limited_also_during_a_ramp(script, robot_path):
    stage = Stage(script, robot_path)
    stage.drive(0.2, 1.0)
    speed = stage.twist()[0]
    assert 0.1 < speed < 0.9
    assert stage.rates() == pytest.approx([speed / 0.05] * 4)
    assert stage.status('wheels').values['limited'] == 'true'


def test_a_command_beyond_the_wheels_keeps_its_direction(script, robot_path):
    stage = Stage(script, robot_path)
    stage.drive(3.0, 2.0, 1.0, 0.5)
    told = np.array(stage.twist())
    assert max(map(abs, stage.rates())) == pytest.approx(20.0)
    assert told / told[0] == pytest.approx([1.0, 0.5, 0.25])


def test_stamped_commands_are_taken_and_their_stamps_do_not_count(script, robot_path):
    stage = Stage(script, robot_path, message=TwistStamped)
    stage.drive(1.0, 0.4)  # stamp 0 in every message: the arrival counts
    assert stage.twist()[0] == pytest.approx(0.4)
    assert stage.node.command.type == 'geometry_msgs/msg/TwistStamped'


@pytest.mark.parametrize(('kind', 'message'), [('twist', Twist), ('twist_stamped', TwistStamped)])
def test_a_fixed_command_type_is_subscribed_as_it_is(script, robot_path, kind, message):
    stage = Stage(script, robot_path, message=message, drive__cmd_vel_type=kind)
    stage.drive(0.5, 0.2)
    assert stage.twist()[0] == pytest.approx(0.2)


def test_the_short_names_of_the_contract_are_understood(script, robot_path):
    stage = Stage(script, robot_path, wheels=Float64MultiArray,
                  command_type='float64_multi_array')
    stage.drive(0.5, 0.2)
    assert stage.node.robot.drive.command_type == 'float64_multi_array'


def test_best_effort_commands_are_heard_when_asked_for_and_named_when_not(script, robot_path):
    best_effort = QoSProfile(depth=10, reliability=ReliabilityPolicy.BEST_EFFORT)
    stage = Stage(script, robot_path, qos=best_effort,
                  drive__cmd_vel_reliability='best_effort')
    stage.drive(0.5, 0.2)
    assert stage.twist()[0] == pytest.approx(0.2)
    with Script() as second:
        deaf = second.add(DriveNode, robot=robot_path)
        second.publisher(Twist, 'cmd_vel', best_effort)
        second.wait_for(lambda: bool(deaf.command.problem), 'the problem to be seen')
        assert 'set drive.cmd_vel_reliability to best_effort' in deaf.command.problem


def test_an_array_for_a_group_controller_has_the_order_of_its_joints(script, robot_path):
    joints = ['rear_left_wheel_joint', 'front_left_wheel_joint', 'rear_right_wheel_joint',
              'front_right_wheel_joint']
    stage = Stage(script, robot_path, wheels=Float64MultiArray,
                  drive__command_type='float64_multi_array', drive__command_joints=joints)
    stage.drive(1.0, 0.0, 0.0, 1.0)
    signs = dict(zip(joints, np.sign(stage.rates())))
    assert signs == {'rear_left_wheel_joint': -1, 'front_left_wheel_joint': -1,
                     'rear_right_wheel_joint': 1, 'front_right_wheel_joint': 1}


def test_the_sign_of_the_encoders_is_the_sign_of_the_commands(script, robot_path):
    stage = Stage(script, robot_path, encoder__sign=[1, -1, 1, -1])
    stage.drive(1.0, 0.5)
    assert stage.rates() == pytest.approx([10.0, -10.0, 10.0, -10.0])
    stage.script.run(2.0, STEP)
    assert [math.copysign(1.0, rate) for rate in stage.rates()] == [1.0] * 4  # no -0.0


def test_nan_is_rejected_and_the_last_command_runs_until_its_time_out(script, robot_path):
    stage = Stage(script, robot_path)
    stage.drive(1.0, 0.4)
    for _ in range(4):
        stage.command(math.nan)
        script.run(0.1, STEP)
    assert stage.twist()[0] == pytest.approx(0.4)
    for _ in range(6):
        stage.command(0.1, linear_y=math.inf)
        script.run(0.1, STEP)
    assert stage.twist() == [0.0] * 3
    status = stage.status('cmd_vel')
    assert status.values['rejected: not a finite number'] == 10


def test_impossible_parts_of_a_command_are_ignored_and_counted(script, robot_path):
    stage = Stage(script, robot_path)
    stage.command(0.3, linear_z=1.0, angular_x=0.5, angular_y=-0.5)
    script.run(0.4, STEP)
    assert stage.twist() == pytest.approx([0.3, 0.0, 0.0])
    counted = stage.status('cmd_vel').values
    assert counted['rejected: linear.z, angular.x or angular.y not 0 (ignored)'] == 1


def test_a_node_that_starts_disabled_waits_for_its_service(script, robot_path):
    stage = Stage(script, robot_path, drive__start_enabled=False)
    stage.drive(0.5, 0.4)
    assert stage.rates() == [0.0] * 4
    assert stage.status('wheels').message == 'disabled: drive.start_enabled is false'
    answer = script.call(SetBool, 'drive_node/enable', SetBool.Request(data=True))
    assert answer.success
    script.run(0.2, STEP)
    assert stage.rates() == [0.0] * 4  # the commands from before do not count
    stage.drive(0.5, 0.4)
    assert stage.twist()[0] == pytest.approx(0.4)


def test_each_transition_is_logged_once_with_its_reason(script, robot_path, capfd):
    stage = Stage(script, robot_path)
    stage.drive(0.5, 0.2)
    script.run(2.0, STEP)
    script.call(SetBool, 'drive_node/enable', SetBool.Request(data=False))
    script.run(0.5, STEP)
    log = capfd.readouterr()
    text = log.out + log.err
    for line in ('idle -> driving: a command arrived',
                 'driving -> timed_out: no command for 0.5 s: decelerating',
                 'timed_out -> disabled: ~/enable called with False'):
        assert text.count(line) == 1


def test_a_simulated_clock_that_jumps_back_stops_the_wheels_until_the_next_command(
        script, robot_path):
    stage = Stage(script, robot_path)
    script.run(5.0, STEP)
    stage.drive(1.0, 0.4)
    script.move_to(script.now_ns - 3_000_000_000)
    script.run(0.1, STEP)
    assert stage.rates() == [0.0] * 4
    assert 'jumped back' in stage.status('wheels').message
    stage.drive(1.0, 0.4)
    assert stage.twist()[0] == pytest.approx(0.4)


def test_a_simulated_clock_that_jumps_ahead_stops_the_wheels(script, robot_path):
    stage = Stage(script, robot_path)
    stage.drive(1.0, 0.4)
    script.move_to(script.now_ns + 3_000_000_000)
    assert stage.rates() == [0.0] * 4
    stage.drive(1.0, 0.4)
    assert stage.twist()[0] == pytest.approx(0.4)


def test_a_command_that_waits_in_the_queue_counts_before_a_time_out_is_declared(
        script, robot_path):
    """As on a busy computer, where the timer is served before the messages."""
    stage = Stage(script, robot_path)
    stage.drive(1.0, 0.4)
    script.advance(0.3)
    stage.steer.publish(Twist(linear=Vector3(x=0.4)))  # not delivered yet
    script.advance(0.3)  # 0.6 s after the last one that was served: time-out is 0.5 s
    assert stage.twist()[0] == pytest.approx(0.4)
    script.advance(0.3)
    script.advance(0.3)
    assert stage.twist()[0] < 0.4


def test_a_simulated_clock_that_stands_still_stops_the_wheels(script, robot_path):
    stage = Stage(script, robot_path, drive__clock_timeout=0.3)
    stage.drive(0.5, 0.4)
    assert stage.twist()[0] == pytest.approx(0.4)
    script.wait_for(lambda: stage.rates() == [0.0] * 4, 'zeros while the clock stands still')
    assert 'stands still' in stage.status('wheels').message
    stage.drive(0.5, 0.4)
    assert stage.twist()[0] == pytest.approx(0.4)


def test_switching_simulated_time_off_while_driving_stops_the_wheels(script, robot_path):
    stage = Stage(script, robot_path)
    stage.drive(0.5, 0.4)
    assert stage.node.set_parameters([parameter('use_sim_time', False)])[0].successful
    script.wait_for(lambda: stage.rates() == [0.0] * 4, 'zeros after the switch')
    count = len(stage.wheels)
    script.wait_for(lambda: len(stage.wheels) > count + 5, 'wheel commands in real time')


def test_live_limits_hold_at_once_and_refused_ones_stop_the_wheels(script, robot_path):
    stage = Stage(script, robot_path)
    stage.drive(1.0, 0.6)
    results = stage.node.set_parameters([parameter('drive.max_velocity', [0.3, 0.3, 1.0])])
    assert results[0].successful
    stage.drive(0.5, 0.6)
    assert stage.twist()[0] == pytest.approx(0.3)
    results = stage.node.set_parameters([parameter('drive.max_velocity', [0.3, 0.3])])
    assert not results[0].successful and 'three entries' in results[0].reason
    script.settle()
    assert stage.rates() == [0.0] * 4
    stage.drive(0.5, 0.6)
    assert stage.twist()[0] == pytest.approx(0.3)  # the old limit still holds


def test_a_live_rate_changes_the_period_of_the_commands(script, robot_path):
    stage = Stage(script, robot_path)
    assert stage.node.set_parameters([parameter('drive.rate', 20)])[0].successful
    stage.wheels.clear()
    script.run(1.0, 0.01)
    assert len(stage.wheels) == 20


def test_a_platform_on_carriers_is_driven_with_measured_hinge_angles(script):
    stage = Stage(script, CARRIERS)
    hinges = script.publisher(JointState, 'joint_states', QoSProfile(depth=10))
    script.connect()
    script.publish(hinges, JointState(name=['front_hinge', 'rear_hinge'], position=[0.5, 0.0]))
    stage.command(0.001)
    script.run(0.02, STEP)
    assert list(stage.wheels[-1].name) == ['front_left', 'front_right', 'rear_left', 'rear_right']
    stage.drive(0.3, 0.4)
    script.publish(hinges, JointState(name=['front_hinge', 'rear_hinge'], position=[0.5, 0.0]))
    script.run(0.02, STEP)
    # models.md D20 by hand, V = (v, 0, 0): hX = v cos, hY = -v sin, rate = (hX + y/e hY) / r
    v = stage.twist()[0]
    left = v * (math.cos(0.5) + 1.2 * math.sin(0.5)) / 0.05
    right = v * (math.cos(0.5) - 1.2 * math.sin(0.5)) / 0.05
    assert stage.rates() == pytest.approx([left, right, v / 0.05, v / 0.05], rel=1e-9)


def test_malformed_hinge_messages_are_counted(script):
    stage = Stage(script, CARRIERS)
    hinges = script.publisher(JointState, 'joint_states', QoSProfile(depth=10))
    script.connect()
    script.publish(hinges, JointState(name=['front_hinge', 'front_hinge'], position=[0.1, 0.2]))
    assert stage.status('cmd_vel').values['rejected: joint_states: joint named twice'] == 1


def test_all_names_are_relative_and_can_be_remapped(script, robot_path):
    steer = script.publisher(Twist, '/nav/steer')
    wheels = script.listen(JointState, '/robot1/wheel_commands')
    limited = script.listen(TwistStamped, '/told')
    script.add(DriveNode, robot=robot_path, namespace='robot1', cli_args=[
        '--ros-args', '-r', 'cmd_vel:=/nav/steer', '-r', 'cmd_vel_limited:=/told'])
    script.connect()
    script.publish(steer, Twist(linear=Vector3(x=0.2)))
    script.run(0.3, STEP)
    assert wheels[-1].velocity[0] == pytest.approx(4.0)
    assert limited[-1].twist.linear.x == pytest.approx(0.2)
    answer = script.call(SetBool, 'robot1/drive_node/enable', SetBool.Request(data=False))
    assert answer.success


def test_the_age_of_stamped_commands_is_shown_and_does_not_matter(script, robot_path):
    stage = Stage(script, robot_path, message=TwistStamped)
    for _ in range(5):
        message = TwistStamped()
        message.header.stamp.sec, message.header.stamp.nanosec = 0, 500_000_000
        message.twist.linear.x = 0.2
        script.publish(stage.steer, message)
        script.run(0.1, STEP)
    assert stage.twist()[0] == pytest.approx(0.2)
    assert float(stage.status('cmd_vel').values['latency max [ms]']) == pytest.approx(900.0)


def test_without_simulated_time_durations_come_from_a_clock_nobody_can_set(script, robot_path):
    node = script.add(DriveNode, robot=robot_path, stepped=False)
    assert node.time_base.clock.clock_type == ClockType.STEADY_TIME
    periodic = [t for t in node.timers if t.timer_period_ns == 20_000_000]
    assert [t.clock.clock_type for t in periodic] == [ClockType.STEADY_TIME]


def test_halting_sends_zeros_at_once(script, robot_path):
    stage = Stage(script, robot_path)
    stage.drive(1.0, 0.4)
    count = len(stage.wheels)
    publishers = stage.node.halt('test')
    script.settle()
    assert [p.topic_name for p in publishers] == ['/wheel_commands']
    assert len(stage.wheels) == count + 1 and stage.rates() == [0.0] * 4


def test_every_shipped_robot_can_be_driven_in_all_directions():
    for path in sorted(robot_file.shipped().glob('*.yaml')):
        with Script() as script:
            stage = Stage(script, path, drive__command_type='joint_state')
            for twist in ((0.2, 0.0, 0.0), (0.0, 0.2, 0.0), (0.0, 0.0, 0.5)):
                stage.drive(0.6, *twist)
                assert stage.twist() == pytest.approx(twist, abs=1e-6), path.name
