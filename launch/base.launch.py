"""A mecanum base: drive and odometry; simulation, goals, recording and viewers on demand.

    ros2 launch mecanum_base base.launch.py robot:=/path/to/robot.yaml
    ros2 launch mecanum_base base.launch.py sim:=true rviz:=true

Nothing but wiring: every setting is a parameter of the robot file.
"""

from launch import LaunchDescription
from launch.actions import DeclareLaunchArgument, GroupAction
from launch.conditions import IfCondition, UnlessCondition
from launch.substitutions import LaunchConfiguration, PathJoinSubstitution
from launch_ros.actions import Node
from launch_ros.substitutions import FindPackageShare

PACKAGE = 'mecanum_base'
ARGUMENTS = {
    'robot': (None, 'robot file (see the README: add your robot)'),
    'namespace': ('', 'namespace of all nodes; topics are relative'),
    'sim': ('false', 'run the simulated hardware'),
    'goal': ('false', 'run the goal node (potential field)'),
    'record': ('false', 'record every topic into an MCAP bag'),
    'composed': ('false', 'drive and odometry in one process (small computers)'),
    'respawn': ('false', 'start drive and odometry again when they end (bad files end at once)'),
    'use_sim_time': ('false', 'follow /clock instead of the system clock'),
    'rviz': ('false', 'start RViz (package rviz2)'),
    'foxglove': ('false', 'start the Foxglove bridge (package foxglove_bridge)'),
}


def generate_launch_description():
    """What `ros2 launch` runs."""
    share = FindPackageShare(PACKAGE)
    robot_file = PathJoinSubstitution([share, 'config', 'mecanum4.yaml'])
    declared = [
        DeclareLaunchArgument(name, default_value=robot_file if default is None else default,
                              description=description)
        for name, (default, description) in ARGUMENTS.items()]
    argument = {name: LaunchConfiguration(name) for name in ARGUMENTS}

    again = {'respawn': argument['respawn'], 'respawn_delay': 2.0}

    def node(executable, condition=None, **more):
        return Node(
            package=PACKAGE, executable=executable, namespace=argument['namespace'],
            parameters=[argument['robot'], {'use_sim_time': argument['use_sim_time']}],
            output='screen', condition=condition, **more)

    return LaunchDescription([
        *declared,
        GroupAction([node('drive_node', **again), node('odometry_node', **again)],
                    condition=UnlessCondition(argument['composed'])),
        node('base_node', IfCondition(argument['composed']), **again),
        Node(package=PACKAGE, executable='sim_node', namespace=argument['namespace'],
             parameters=[argument['robot'], {'sim.publish_clock': argument['use_sim_time']}],
             output='screen', condition=IfCondition(argument['sim'])),
        node('goal_node', IfCondition(argument['goal'])),
        node('record_node', IfCondition(argument['record'])),
        Node(package='rviz2', executable='rviz2', output='screen',
             arguments=['-d', PathJoinSubstitution([share, 'config', 'mecanum_base.rviz'])],
             parameters=[{'use_sim_time': argument['use_sim_time']}],
             condition=IfCondition(argument['rviz'])),
        Node(package='foxglove_bridge', executable='foxglove_bridge', output='screen',
             parameters=[{'use_sim_time': argument['use_sim_time']}],
             condition=IfCondition(argument['foxglove'])),
    ])
