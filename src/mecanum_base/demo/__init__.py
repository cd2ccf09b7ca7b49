"""The main job end to end: nodes over ROS 2 topics, a bag, a comparison with the truth."""
