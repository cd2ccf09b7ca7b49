"""Base-driver layer for mecanum and omni robots on ROS 2.

    core/     numpy and the standard library only: kinematics, estimation, models of the sources
    sim/      simulated hardware: plant, sensors, faults, scenarios
    bag/      recordings: read, replay, analyse, calibrate
    ros/      thin rclpy nodes and the scripted executor
    cli/      the `mecanum` command, one file a verb
    robot     everything a robot file says;  robot_file reads it
    messages  the only file that knows ROS field names
"""

__version__ = '0.1.0'
