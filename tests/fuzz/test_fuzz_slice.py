"""A slice of the fuzz campaign; the whole: make fuzz."""

import fuzz_bags


def test_mutated_bags_neither_crash_nor_hang_nor_lose_in_silence(tmp_path):
    number, outcomes, failures = fuzz_bags.campaign(400, 8.0, 7, tmp_path)
    assert not failures, failures
    assert number > 30, outcomes
    assert outcomes.get('loss stated') and outcomes.get('refused') is not None
