"""A slice of the fuzz campaign; the whole: make fuzz."""

import importlib.util
import pathlib


def test_mutated_bags_neither_crash_nor_hang_nor_lose_in_silence(tmp_path):
    spec = importlib.util.spec_from_file_location(
        'fuzz_bags', pathlib.Path(__file__).with_name('fuzz_bags.py'))
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    number, outcomes, failures = module.campaign(400, 8.0, 7, tmp_path)
    assert not failures, failures
    assert number > 30, outcomes
    assert outcomes.get('loss stated') and outcomes.get('refused') is not None
