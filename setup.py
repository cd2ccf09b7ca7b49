"""Packaging for pip and colcon (ament_python)."""

import pathlib
from glob import glob

from setuptools import find_packages, setup

NAME = 'mecanum_base'
HERE = pathlib.Path(__file__).resolve().parent  # colcon --symlink-install runs a link to this file
NODES = ('drive', 'odometry', 'sim', 'goal', 'record', 'base')

setup(
    name=NAME,
    version='0.1.0',
    description='ROS 2 base driver for mecanum and omni robots: odometry and slip estimates',
    long_description=(HERE / 'README.md').read_text(encoding='utf-8'),
    long_description_content_type='text/markdown',
    license='Apache-2.0',
    author='mecanum_base founders',
    author_email='founders@mecanum-base.dev',
    maintainer='mecanum_base founders',
    maintainer_email='founders@mecanum-base.dev',
    python_requires='>=3.10',
    package_dir={'': 'src'},
    packages=find_packages('src'),
    package_data={NAME: ['py.typed', 'report/*.html', 'report/*.css', 'report/*.js']},
    data_files=[
        ('share/ament_index/resource_index/packages', [f'resource/{NAME}']),
        (f'share/{NAME}', ['package.xml']),
        (f'share/{NAME}/config', glob('config/*.*')),
        (f'share/{NAME}/config/scenarios', glob('config/scenarios/*.yaml')),
        (f'share/{NAME}/config/integration', glob('config/integration/*.*')),
        (f'share/{NAME}/launch', glob('launch/*.py')),
    ],
    zip_safe=True,
    install_requires=['numpy>=1.22', 'PyYAML>=5.4', 'mcap>=1.5', 'rosbags>=0.10.6'],
    extras_require={
        'ros': ['ros-jazzy-rclpy[fastrtps]==7.1.6', 'ros-jazzy-common-interfaces==5.3.6'],
        'report': ['matplotlib>=3.6', 'plotly>=5.15', 'Jinja2>=3.0'],
        'fast': ['numba>=0.58', 'scipy>=1.9'],  # numba takes BLAS from scipy
        'fleet': ['dask[distributed]>=2023.5'],
        'parquet': ['pyarrow>=12'],
        'mesh': ['trimesh>=3.20'],
        'test': ['trimesh>=3.20', 'pytest>=7', 'hypothesis>=6.80', 'ruff>=0.6', 'mypy>=1.8',
                 'import-linter>=2.0', 'types-PyYAML', 'scipy>=1.9', 'psutil>=5.9',
                 'mcap-ros2-support>=0.5'],
    },
    entry_points={
        'console_scripts': [
            f'mecanum = {NAME}.cli.main:main',
            *(f'{node}_node = {NAME}.ros.{node}_node:main' for node in NODES),
        ],
    },
)
