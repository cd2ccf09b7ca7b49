"""From encoder and IMU samples to odometry and slip."""
