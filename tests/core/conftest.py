"""Settings of the property tests, and the path to the test helpers of this folder."""

import pathlib
import sys

import hypothesis

sys.path.insert(0, str(pathlib.Path(__file__).parent))  # wheel_strategies, reference_adapters

# deterministic: the same examples in every run; no deadline: two busy cores
hypothesis.settings.register_profile('core', derandomize=True, deadline=None, max_examples=30,
                                     database=None)
hypothesis.settings.load_profile('core')
