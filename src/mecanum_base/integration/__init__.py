"""Bridges to other people's files: controller YAML, URDF, access policies."""
