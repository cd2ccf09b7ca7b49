"""The service that switches the simulated fault on and off."""

import pytest

pytest.importorskip('rclpy')

from sensor_msgs.msg import JointState
from std_srvs.srv import SetBool

from mecanum_base.robot_file import read_parameters, shipped
from mecanum_base.ros.qos import SENSOR
from mecanum_base.ros.scripted import Script, parameter
from mecanum_base.ros.sim_node import SimNode


def test_the_fault_of_the_parameters_goes_off_and_on_by_service():
    with Script() as script:
        robot = read_parameters(shipped() / 'mecanum4.yaml')
        node = script.add(SimNode, robot=robot, stepped=False, start_ns=script.now_ns)
        states = script.listen(JointState, 'joint_states', SENSOR)
        script.before_step(lambda now, following: node.step_to(following))
        script.connect()

        def arrived(seconds):
            before = len(states)
            script.run(seconds, 0.02)
            return len(states) - before

        def switch(on):
            return script.call(SetBool, 'sim_node/fault', SetBool.Request(data=on))

        answer = switch(True)
        assert not answer.success and 'sim.fault' in answer.message
        assert arrived(0.2) >= 18
        node.set_parameters([parameter('sim.fault', 'encoder_dropped')])
        assert arrived(0.2) <= 1  # one was on its way
        assert switch(False).success
        assert arrived(0.2) >= 18
        assert switch(True).message == 'encoder_dropped acts'
        assert arrived(0.2) <= 1
