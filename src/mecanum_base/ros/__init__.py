"""Thin rclpy nodes, their parameters and process rules, and the scripted executor."""
