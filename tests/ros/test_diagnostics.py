"""Diagnostics say in words which source is silent, rejected or well."""

import pytest

pytest.importorskip('rclpy')

from diagnostic_msgs.msg import DiagnosticArray
from rclpy.node import Node

from mecanum_base.ros import diagnostics
from mecanum_base.ros.diagnostics import ERROR, OK, STALE, WARN, Diagnostics, Source, Status
from mecanum_base.ros.scripted import Script


@pytest.fixture
def now(monkeypatch):
    """A monotonic clock that a test moves: ``now[0]`` in seconds."""
    value = [100.0]
    monkeypatch.setattr(diagnostics.time, 'monotonic', lambda: value[0])
    return value


def arrived(source, count):
    for _ in range(count):
        source.arrived(0.002)


def test_a_source_that_never_spoke_is_stale(now):
    assert Source('imu', 'imu/data_raw').report().level == STALE


def test_a_source_nobody_needs_may_be_silent_with_a_word_of_warning(now):
    status = Source('imu', 'imu/data_raw').report(needed=False, silent='no IMU')
    assert (status.level, status.message) == (WARN, 'no IMU')


def test_rate_and_latency_are_those_since_the_last_report(now):
    source = Source('imu', 'imu/data_raw')
    arrived(source, 5)
    now[0] += 1.0
    source.report()
    arrived(source, 200)
    now[0] += 1.0
    values = source.report().values
    assert values['rate [Hz]'] == '200.0' and values['received'] == 205
    assert values['latency [ms]'] == '2.00'


def test_some_rejected_are_a_warning_all_rejected_an_error_and_then_it_is_over(now):
    source = Source('joint_states', 'joint_states')
    arrived(source, 10)
    source.reject('late')
    now[0] += 0.5
    status = source.report()
    assert status.level == WARN and '1 of 10 rejected' in status.message
    arrived(source, 2)
    source.reject('late')
    source.reject('late')
    assert source.report().level == ERROR
    arrived(source, 2)
    status = source.report()
    assert status.level == OK and status.values['rejected: late'] == 3


def test_a_source_that_fell_silent_is_stale_after_a_second(now):
    source = Source('joint_states', 'joint_states')
    arrived(source, 1)
    now[0] += 0.9
    assert source.report().level == OK
    now[0] += 0.2
    status = source.report()
    assert status.level == STALE and 'silent for 1.1 s' in status.message


def test_counters_that_start_anew_do_no_harm(now):
    source = Source('imu', 'imu/data_raw')
    arrived(source, 1)
    source.report(rejected={'late': 5})
    assert source.report(rejected={}).level == OK


def test_statuses_are_published_under_the_name_of_the_node():
    with Script() as script:
        node = script.add(Node, name='mine')
        heard = script.listen(DiagnosticArray, '/diagnostics')
        sender = Diagnostics(node, lambda: [Status('thing', WARN, 'careful', {'size': 3})])
        script.settle()
        sender.publish()
        script.settle()
        found = {s.name: s for s in heard[-1].status}
        thing = found['mine: thing']
        assert (thing.level, thing.message, thing.hardware_id) == (b'\x01', 'careful',
                                                                   'mecanum_base')
        assert [(v.key, v.value) for v in thing.values] == [('size', '3')]
        assert {'mine: executor', 'mine: clock'} <= set(found)
        assert heard[-1].header.stamp.sec == script.now_ns // 10**9


def test_a_clock_that_was_never_heard_is_named():
    with Script() as script:
        node = script.add(Node, name='mine')
        sender = Diagnostics(node, list)
        script.move_to(0)
        status = {s.name: s for s in sender.publish()}['mine: clock']
        assert status.level == STALE and 'nothing was heard on /clock' in status.message
