"""Recordings: record, recover, read, replay, analyse."""
