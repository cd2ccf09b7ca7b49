"""Service ``~/fault`` (std_srvs/SetBool) of the sim node: the fault of ``sim.fault`` on and off.

    ros2 param set /sim_node sim.fault imu_frozen          # acts at once
    ros2 service call /sim_node/fault std_srvs/srv/SetBool '{data: false}'
"""

from __future__ import annotations

from typing import Any

from std_srvs.srv import SetBool

from mecanum_base.sim.simulation import Simulation


class FaultService:
    """Switches the fault that the node's parameters describe."""

    def __init__(self, node: Any, simulation: Simulation) -> None:
        self._node, self._simulation = node, simulation
        node.create_service(SetBool, '~/fault', self._answer)

    def _answer(self, request: Any, response: Any) -> Any:
        sim = self._node.robot.sim
        if not request.data:
            self._simulation.set_fault('none')
            response.success, response.message = True, 'no fault acts'
        elif sim.fault == 'none':
            response.success, response.message = False, 'sim.fault is none: set it first'
        else:
            wheels = tuple(int(wheel) for wheel in sim.fault_wheels)
            self._simulation.set_fault(sim.fault, wheels, sim.fault_value or None)
            response.success, response.message = True, f'{sim.fault} acts'
        return response
