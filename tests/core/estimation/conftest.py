"""Path to the sample generator of this folder."""

import pathlib
import sys

sys.path.insert(0, str(pathlib.Path(__file__).parent))  # staged_drive
