"""``python -m mecanum_base.accuracy``."""

import sys

from mecanum_base.accuracy.command import main

if __name__ == '__main__':
    sys.exit(main())
