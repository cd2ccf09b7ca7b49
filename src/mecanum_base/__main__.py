"""`python -m mecanum_base` is the `mecanum` command."""

import sys

from mecanum_base.cli.main import main

if __name__ == '__main__':
    sys.exit(main())
