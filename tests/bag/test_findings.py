"""Each finding of `mecanum analyze`, on recordings made to show it (and not without it)."""

import json
from types import SimpleNamespace

import driving
import numpy as np
import pytest

from mecanum_base.bag.analysis.analyze import Options, analyze
from mecanum_base.bag.analysis.estimate import slip_findings
from mecanum_base.bag.analysis.fleet import analyze_all, failed

MS = 1_000_000
LEVER = driving.LX + driving.LY


def spin(make, seconds=9.0, gyro=1.0, late_ns=0, noise=0.002, bias=0.01, truth_scale=None):
    """2 s of rest, then turning to and fro: wheels and gyro of a base that turns on the spot."""
    generator = np.random.default_rng(1)
    t = np.arange(0, seconds, 0.01)
    rate = np.where(t < 2.0, 0.0, 0.8 * np.sin(2.0 * (t - 2.0)))
    yaw = np.concatenate(([0.0], np.cumsum(rate * 0.01)))[:-1]
    entries = []
    for k, (time, w, angle) in enumerate(zip(t, rate, yaw)):
        stamp = make.T0 + round(time * 1e9)
        turn = angle * LEVER / 0.05
        shaken = gyro * w + bias + noise * generator.normal()
        entries.append(('/imu/data_raw', stamp + MS, make.imu(
            stamp + late_ns, (noise * generator.normal(), noise * generator.normal(), shaken),
            0.02 * generator.normal(size=3) + [0, 0, 9.81])))
        if k % 2 == 0:
            entries.append(('/joint_states', stamp + MS, make.joint_state(
                stamp, [-turn, turn, -turn, turn])))
        if truth_scale is not None and k % 5 == 0:
            entries.append(('/ground_truth/odom', stamp + MS, make.odometry(
                stamp, (0, 0, truth_scale * angle))))
    return entries


def codes(tmp_path, make, entries, robot=True, name='a.mcap', **options):
    path = make.write_mcap(tmp_path / name, sorted(entries, key=lambda e: e[1]))
    file = tmp_path / 'robot.yaml'
    file.write_text(driving.YAML)
    result = analyze(path, Options(str(file) if robot else None, **options))
    json.dumps(result, allow_nan=False)
    return {f['code']: f for f in result['findings']}, result


def test_a_sound_recording_has_no_blocker_and_no_warning(tmp_path, make):
    _, result = codes(tmp_path, make, spin(make))
    assert result['counts']['blocker'] == 0
    assert [f['code'] for f in result['findings'] if f['severity'] == 'warning'] == []


def test_without_a_robot_file_only_the_data_are_judged(tmp_path, make):
    found, result = codes(tmp_path, make, spin(make), robot=False)
    assert 'gyro_bias' in found and 'parity' not in found and 'drift' not in found
    assert found['gyro_bias']['numbers']['z'] == pytest.approx(0.01, abs=0.001)
    assert result['counts']['blocker'] == 0


def test_gaps_are_counted_with_their_place(tmp_path, make):
    entries = [e for e in spin(make) if not (
        e[0] == '/joint_states' and 5.0 < (e[1] - make.T0) / 1e9 < 5.5)]
    found, _ = codes(tmp_path, make, entries)
    assert found['gaps']['severity'] == 'warning'
    start, end = found['gaps']['spans'][0]
    assert start == pytest.approx(5.0, abs=0.03) and end == pytest.approx(5.5, abs=0.03)


def test_a_burst_of_ticks_is_late_not_missing(tmp_path, make):
    entries = [(t, s if not 2.0 < (s - make.T0) / 1e9 < 2.4 or t != '/wheel_ticks'
                else make.T0 + 2400 * MS + k, m) for k, (t, s, m) in enumerate(make.drive(5.0))]
    found, _ = codes(tmp_path, make, entries)
    assert found['gaps']['topic'] == '/wheel_ticks'
    assert 'the others only came late' in found['gaps']['evidence']
    assert found['gaps']['numbers']['share'] < 0.01


def test_noisy_wheel_speeds_are_held_against_one_count(tmp_path, make):
    generator = np.random.default_rng(2)
    entries = [(t, s, make.joint_state(s, np.array(m.position) + 0.1 * generator.normal(size=4))
                if t == '/joint_states' else m) for t, s, m in make.drive(4.0)]
    found, _ = codes(tmp_path, make, entries)
    # 2 pi / 4096 counts / 0.02 s; differences of white noise of 0.1 rad over 0.02 s: 7 rad/s
    assert found['encoder_noise']['numbers']['one_count'] == pytest.approx(0.0767, abs=0.001)
    assert 4.0 < found['encoder_noise']['numbers']['sigma'] < 15.0


def test_a_poor_reference_neither_confirms_nor_denies_the_scales(tmp_path, make):
    generator = np.random.default_rng(3)
    entries = [(t, s, make.odometry(s, 0.3 * generator.normal(size=3))
                if t == '/ground_truth/odom' else m) for t, s, m in spin(make, truth_scale=1.0)]
    found, _ = codes(tmp_path, make, entries)
    assert 'scales_unclear' in found and 'scales_agree' not in found


def test_doubt_from_start_to_end_is_no_slip_episode():
    episode = {'wheels': ['a'], 'start': 0.5, 'end': 9.5, 'slip_distance': 1.0, 'kind': 'all',
               'probability': 1.0}
    found = SimpleNamespace(episodes=(episode,), seconds=10.0, path=2.0,
                            health=SimpleNamespace(imu='gyro'))
    assert [f.code for f in slip_findings(found, 0, True)] == ['wheels_doubted']
    found.seconds = 60.0
    assert [f.code for f in slip_findings(found, 0, True)] == ['slip']


def test_stamps_that_step_back_and_repeat_are_found(tmp_path, make):
    imus = [e for e in spin(make) if e[0] == '/imu/data_raw']
    for k in range(100, 800, 150):
        topic, log, _ = imus[k]
        imus[k] = (topic, log, make.imu(log - MS - 14 * MS, (0, 0, 0.01)))
        imus[k + 50] = (topic, imus[k + 50][1], imus[k + 49][2])
    rest = [e for e in spin(make) if e[0] != '/imu/data_raw']
    found, _ = codes(tmp_path, make, imus + rest)
    # 10 ms apart and 14 ms early: 4 ms before the stamp of the message before
    assert found['stamps_step_back']['numbers']['largest'] == pytest.approx(0.004, abs=1e-6)
    assert found['stamps_step_back']['numbers']['count'] == len(range(100, 800, 150))
    assert found['equal_stamps']['numbers']['count'] == len(range(100, 800, 150))


def test_zero_stamps_block(tmp_path, make):
    entries = [(t, s, make.imu(0, (0, 0, 0.0)) if t == '/imu/data_raw' else m)
               for t, s, m in spin(make)]
    found, _ = codes(tmp_path, make, entries, robot=False)
    assert found['zero_stamps']['severity'] == 'blocker'


def test_clocks_of_two_computers_show_as_offset_and_skew(tmp_path, make):
    entries = [(t, s, make.imu(s + 480 * MS, (0, 0, 0.01)) if t == '/imu/data_raw' else m)
               for t, s, m in spin(make)]
    found, _ = codes(tmp_path, make, entries, robot=False)
    assert found['clock_offset']['numbers']['offset'] == pytest.approx(-0.48, abs=0.01)
    assert found['skew']['numbers']['skew'] == pytest.approx(0.48, abs=0.01)


def test_a_late_gyro_is_measured_from_the_motion(tmp_path, make):
    found, _ = codes(tmp_path, make, spin(make, late_ns=70 * MS))
    assert found['time_offset']['numbers']['offset'] == pytest.approx(0.07, abs=0.01)


def test_a_wrong_yaw_scale_and_a_wrong_sign_are_found(tmp_path, make):
    found, _ = codes(tmp_path, make, spin(make, gyro=0.9), name='a.mcap')
    assert found['yaw_scale']['numbers']['scale'] == pytest.approx(0.9, abs=0.01)
    found, result = codes(tmp_path, make, spin(make, gyro=-1.0), name='b.mcap')
    assert found['yaw_sign']['severity'] == 'blocker'
    assert result['counts']['blocker'] >= 1


def test_a_frozen_imu_is_found_with_its_time(tmp_path, make):
    frozen = make.imu(make.T0, (0.1, 0.2, 0.3))
    entries = []
    for topic, log, msg in spin(make):
        if topic == '/imu/data_raw' and 6.0 < (log - make.T0) / 1e9 < 7.8:
            msg = make.imu(log, (0.1, 0.2, 0.3))
        entries.append((topic, log, msg))
    found, _ = codes(tmp_path, make, entries)
    assert found['imu_frozen']['severity'] == 'warning' and frozen
    assert found['imu_frozen']['numbers']['seconds'] == pytest.approx(1.8, abs=0.1)


def test_the_accelerometer_units_and_mounting_are_judged(tmp_path, make):
    def changed(accel):
        return [(t, s, make.imu(s, (0, 0, 0.01 * k % 0.02), accel)
                 if t == '/imu/data_raw' else m) for k, (t, s, m) in enumerate(spin(make))]
    assert codes(tmp_path, make, changed((0, 0, 1.0)), False, 'a.mcap')[0]['accel_in_g']
    assert codes(tmp_path, make, changed((0, 0, 0.01)), False, 'b.mcap')[0]['gravity_removed']
    assert codes(tmp_path, make, changed((9.81, 0, 0)), False, 'c.mcap')[0]['imu_tilted']
    assert codes(tmp_path, make, changed((0.8, 0, 9.7)), False, 'd.mcap')[0]['gravity_leak']


def test_a_stuck_wheel_a_reset_and_a_jump_are_found(tmp_path, make):
    def changed(change):
        return [(t, s, make.joint_state(s, change((s - make.T0) / 1e9, np.array(m.position)))
                 if t == '/joint_states' else m) for t, s, m in straight]
    straight = make.drive(6.0)
    stuck = changed(lambda t, p: p * [1, 1, 1, 0])
    found, _ = codes(tmp_path, make, stuck, False, 'a.mcap')
    assert 'rear_right' in found['encoder_stuck']['title']
    found, _ = codes(tmp_path, make, changed(
        lambda t, p: p if t < 4 else p - [0, 16.2, 0, 0]), False, 'b.mcap')
    assert 'front_right' in found['encoder_reset']['title']
    found, _ = codes(tmp_path, make, changed(
        lambda t, p: p + ([0, 0, 50.0, 0] if 3 < t < 3.015 else 0)), False, 'c.mcap')
    assert 'rear_left' in found['encoder_jump']['title']


def test_wheels_that_run_in_the_air_block(tmp_path, make):
    entries = [(t, s, make.imu(s, (0, 0, 0.001 * (k % 3)))
                if t == '/imu/data_raw' else m) for k, (t, s, m) in enumerate(spin(make))]
    found, _ = codes(tmp_path, make, entries)
    assert found['wheels_run_free']['severity'] == 'blocker'


def test_drift_is_given_against_the_truth_for_wheels_and_estimator(tmp_path, make):
    found, result = codes(tmp_path, make, spin(make, truth_scale=1.0))
    names = {d['name']: d for d in result['drift']}
    assert set(names) == {'wheels only', 'estimator'}
    assert names['wheels only']['alignment'] == 'start'
    assert names['wheels only']['yaw_final'] == pytest.approx(0.0, abs=0.02)
    assert 'scales_agree' in found
    found, result = codes(tmp_path, make, spin(make, truth_scale=0.9), name='b.mcap')
    assert found['scales_off']['numbers']['turning'] == pytest.approx(0.9, abs=0.01)


def test_a_cut_bag_says_how_much_is_lost(tmp_path, make):
    path = make.write_mcap(tmp_path / 'a.mcap', spin(make), chunk_size=8192)
    with open(path, 'rb') as file:
        data = file.read()
    (tmp_path / 'b.mcap').write_bytes(data[:len(data) * 2 // 3])
    result = analyze(str(tmp_path / 'b.mcap'), Options())
    found = {f['code']: f for f in result['findings']}
    assert found['loss']['numbers']['bytes'] > 0


def test_an_unreadable_bag_is_a_result_with_a_blocker(tmp_path):
    (tmp_path / 'a.mcap').write_text('no bag')
    result = analyze(str(tmp_path / 'a.mcap'), Options())
    assert result['counts'] == {'blocker': 1, 'warning': 0, 'note': 0}


def test_one_bags_failure_never_loses_the_others(tmp_path, make):
    good = make.write_mcap(tmp_path / 'a.mcap', spin(make, 3.0))
    (tmp_path / 'b.mcap').write_text('no bag')
    jobs = [(good, Options()), (str(tmp_path / 'b.mcap'), Options()), (good, Options())]
    alone = analyze_all(jobs, workers=1)
    assert [r['counts']['blocker'] for r in alone] == [0, 1, 0]
    pool = analyze_all(jobs, workers=2)
    assert pool == alone
    assert failed(jobs[0], 'the worker died')['counts']['blocker'] == 1


def test_a_dask_cluster_gives_the_same_results(tmp_path, make):
    distributed = pytest.importorskip('distributed', reason='needs the extra fleet')
    good = make.write_mcap(tmp_path / 'a.mcap', spin(make, 3.0))
    jobs = [(good, Options()), (str(tmp_path / 'none.mcap'), Options())]
    with distributed.LocalCluster(n_workers=1, threads_per_worker=1, processes=False,
                                  dashboard_address=None) as cluster:
        result = analyze_all(jobs, scheduler=cluster.scheduler_address)
    assert result == analyze_all(jobs, workers=1)


def test_a_pose_topic_without_one_readable_message_is_reported_not_raised(tmp_path, make):
    entries = [('/ground_truth/odom', s, ('nav_msgs/msg/Odometry', b'\0\1\0\0' + b'x' * 9))
               for s in range(make.T0, make.T0 + 10**9, 10**8)]
    found, _ = codes(tmp_path, make, entries, robot=False)
    assert found['malformed']['evidence'].startswith('10 messages')
