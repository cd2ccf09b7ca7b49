"""The path to the campaign of this folder, which is also a program of its own."""

import pathlib
import sys

sys.path.insert(0, str(pathlib.Path(__file__).parent))  # fuzz_bags
