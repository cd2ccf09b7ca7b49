"""Make the virtual environment of this project; run by make.

A sourced ROS 2 (rclpy importable) is used through --system-site-packages, never mixed with the
wheels from PyPI. Otherwise the Jazzy wheels are installed; they exist for x86_64 Linux with
glibc 2.28 or newer only, and anything else ends here with one line that says so.
"""

import importlib.util
import os
import pathlib
import platform
import subprocess
import sys

EXTRAS = ['report', 'test', 'fast', 'mesh', 'fleet']


def fail(reason):
    """End with one line."""
    sys.exit(f'mecanum_base setup: {reason}')


def check_machine(has_ros):
    """Say in one line why this machine cannot be used, if so."""
    if not (3, 10) <= sys.version_info[:2] <= (3, 13):
        fail(f'needs Python 3.10 to 3.13, this is {platform.python_version()} '
             '(choose one with: make PYTHON=python3.12 ...)')
    if importlib.util.find_spec('venv') is None or importlib.util.find_spec('ensurepip') is None:
        fail('needs the Python module venv (Debian, Ubuntu: apt install python3-venv)')
    if has_ros:
        return
    libc, version = platform.libc_ver()
    number = tuple(int(part) for part in version.split('.')[:2]) if version else (0, 0)
    if sys.platform != 'linux' or platform.machine() != 'x86_64' or libc != 'glibc' \
            or number < (2, 28):
        fail(f'ROS 2 Jazzy wheels exist for x86_64 Linux with glibc >= 2.28 only, this is '
             f'{platform.machine()} {sys.platform} {libc} {version}: install ROS 2 Jazzy, source '
             'its setup.bash and run make again')


def run(words, **options):
    """Run a command; its output is shown only if it fails."""
    result = subprocess.run(words, capture_output=True, text=True, **options)
    if result.returncode:
        lines = [line for line in (result.stdout + result.stderr).splitlines()
                 if line and not line.startswith('WARNING')]
        print('\n'.join(lines[-15:]), file=sys.stderr)
        fail(f'failed: {" ".join(str(word) for word in words)}')


def main():
    """Create or update the environment named by the first argument."""
    venv = pathlib.Path(sys.argv[1])
    has_ros = importlib.util.find_spec('rclpy') is not None and sys.prefix == sys.base_prefix
    check_machine(has_ros)
    environment = {k: v for k, v in os.environ.items() if k != '_ROS_WHEELS_BOOTSTRAP_COMPLETE'}
    if not has_ros:
        environment.pop('LD_LIBRARY_PATH', None)
    source = 'the sourced ROS 2' if has_ros else 'ROS 2 Jazzy wheels'
    print(f'setting up {venv} with {source} (once, about a minute) ...', flush=True)
    options = ['--system-site-packages'] if has_ros else []
    run([sys.executable, '-m', 'venv', *options, venv], env=environment)
    pip = [venv / 'bin' / 'python', '-m', 'pip', 'install', '-q', '--no-compile',
           '--disable-pip-version-check']
    run([*pip, '--upgrade', 'pip'], env=environment)  # old ones resolve and install far slower
    extras = EXTRAS if has_ros else ['ros', *EXTRAS]
    run([*pip, '-e', f'.[{",".join(extras)}]'], env=environment)
    print(f'{venv} is ready', flush=True)


if __name__ == '__main__':
    main()
