"""The 81 combinations of four wheels driven forward, backward or not (source T, Table I)."""
