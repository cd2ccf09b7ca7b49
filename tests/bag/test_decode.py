import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from mecanum_base import messages
from mecanum_base.bag import decode
from mecanum_base.bag.block import Block, Channel

JOINTS = ('front_left_wheel_joint', 'front_right_wheel_joint', 'rear_left_wheel_joint',
          'rear_right_wheel_joint')


def block_of(payloads, kind):
    length = np.array([len(p) for p in payloads], dtype=np.int64)
    count = len(payloads)
    return Block(b''.join(payloads), np.cumsum(length) - length, length,
                 np.arange(count, dtype=np.int64) * 1000, np.zeros(count, dtype=np.int64),
                 (Channel('/t', kind),))


def rows(block):
    return np.arange(len(block))


def one_by_one(make, msgs):
    """What the live node would make of each message: the oracle of all bulk reading."""
    kept, rejected, foreign = [], [], 0
    for index, msg in enumerate(msgs):
        try:
            sample = messages.wheel_sample(msg, JOINTS)
        except messages.MalformedMessage as error:
            rejected.append(str(error))
            continue
        if sample is None:
            foreign += 1
        else:
            kept.append((index, sample))
    return kept, rejected, foreign


NAMES = st.lists(st.sampled_from([*JOINTS, 'arm', 'gripper']), min_size=0, max_size=7)


@settings(max_examples=60, deadline=None)
@given(st.lists(st.tuples(NAMES, st.booleans(), st.sampled_from(['same', 'none', 'short']),
                          st.text(max_size=5), st.booleans()), min_size=1, max_size=12))
def test_bulk_joint_states_equal_message_by_message(make_module, shapes):
    make, generator = make_module, np.random.default_rng(5)
    msgs, payloads = [], []
    for index, (names, with_velocity, length, frame, little) in enumerate(shapes):
        count = {'same': len(names), 'none': 0, 'short': max(len(names) - 1, 0)}[length]
        msg = make.joint_state(make.T0 + index, generator.normal(size=count), names,
                               generator.normal(size=len(names)) if with_velocity else (),
                               frame=frame.replace('\0', ''))
        msgs.append(msg)
        payloads.append(make.serialized(msg, little))
    block = block_of(payloads, decode.JOINT_STATE)
    found = decode.wheel_readings(block, rows(block), JOINTS)
    kept, rejected, foreign = one_by_one(make, msgs)
    assert found.row.tolist() == [index for index, _ in kept]
    assert found.stamp_ns.tolist() == [sample.stamp_ns for _, sample in kept]
    for name in ('position', 'velocity'):
        wanted = [getattr(sample, name) for _, sample in kept]
        np.testing.assert_array_equal(found.values[name], np.reshape(wanted, (-1, 4)))
    assert sorted(found.rejected) == sorted(rejected)
    assert found.foreign == foreign


@pytest.fixture(scope='module')
def make_module(request):
    """The message builders for a hypothesis test (a function-scoped fixture is not allowed)."""
    import importlib.util
    import pathlib
    spec = importlib.util.spec_from_file_location(
        'bag_messages', pathlib.Path(__file__).with_name('conftest.py'))
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module


def test_bulk_imu_equals_message_by_message_and_missing_sensors_are_nan(make):
    generator = np.random.default_rng(3)
    msgs = [make.imu(make.T0 + i, generator.normal(size=3), generator.normal(size=3),
                     frame='imu' if i % 3 else 'other', no_accel=i % 5 == 0) for i in range(50)]
    msgs[7].angular_velocity_covariance[0] = -1.0
    block = block_of([make.serialized(m, i % 7 > 0) for i, m in enumerate(msgs)], decode.IMU)
    found = decode.imu_readings(block, rows(block))
    samples = [messages.imu_sample(m) for m in msgs]
    assert found.row.tolist() == list(range(50))
    np.testing.assert_array_equal(found.stamp_ns, [s.stamp_ns for s in samples])
    np.testing.assert_array_equal(found.values['gyro'], [s.gyro for s in samples])
    np.testing.assert_array_equal(found.values['accel'], [s.accel for s in samples])
    assert np.isnan(found.values['accel'][0]).all() and np.isnan(found.values['gyro'][7]).all()


@pytest.mark.parametrize('bits', [32, 64])
def test_ticks_take_the_log_time_and_wrong_lengths_are_rejected(make, bits):
    low, high = -2**(bits - 1), 2**(bits - 1) - 1
    grids = [[low, high, 0, -1], [1, 2, 3], [5, 6, 7, 8], []]
    kind = f'std_msgs/msg/Int{bits}MultiArray'
    block = block_of([make.serialized(make.ticks(g, bits)) for g in grids], kind)
    found = decode.tick_readings(block, rows(block), 4, kind)
    assert found.values['counts'].tolist() == [grids[0], grids[2]]
    assert found.stamp_ns.tolist() == [0, 2000]
    assert found.rejected == ['wheel_ticks length differs from wheels'] * 2


def test_many_layouts_in_one_block_are_all_read(make):
    msgs = [make.joint_state(make.T0 + i, [1.0 * i] * 4, frame='f' * i) for i in range(40)]
    block = block_of([make.serialized(m) for m in msgs], decode.JOINT_STATE)
    found = decode.wheel_readings(block, rows(block), JOINTS)
    assert found.values['position'][:, 2].tolist() == [1.0 * i for i in range(40)]


def test_bytes_that_do_not_fit_the_type_are_rejected_not_raised(make):
    good = make.serialized(make.imu(make.T0, (1, 2, 3)))
    generator = np.random.default_rng(9)
    payloads = [good, b'', b'\0\1\0\0', good[:100], good[:-40],
                good[:16] + b'\xff\xff\xff\xff' + good[20:], generator.bytes(324)]
    block = block_of(payloads, decode.IMU)
    found = decode.imu_readings(block, rows(block))
    assert 0 in found.row.tolist()
    assert len(found.rejected) + len(found.row) == len(payloads)
    assert len(found.rejected) >= 5


def test_a_trailing_empty_array_as_rclpy_writes_it_is_read(make):
    """rclpy leaves 4 bytes too many behind an empty last array (toolchain notes, 1.8)."""
    plain = make.serialized(make.joint_state(make.T0, [1, 2, 3, 4]))
    block = block_of([plain, plain + b'\0\0\0\0'], decode.JOINT_STATE)
    found = decode.wheel_readings(block, rows(block), JOINTS)
    assert found.values['position'].tolist() == [[1, 2, 3, 4]] * 2
