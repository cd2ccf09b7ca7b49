"""Files that the fuzz campaign once read wrongly, built on purpose."""

import struct

import fuzz_bags
import pytest

from mecanum_base.bag.reader import Bag
from mecanum_base.core.errors import BagError

CHUNK, MESSAGE_INDEX, STATISTICS = 6, 7, 11


@pytest.fixture(scope='module')
def bags(tmp_path_factory):
    """{name: path} of the small bags the campaign starts from."""
    return {path.name: path for path, _ in fuzz_bags.originals(tmp_path_factory.mktemp('bags'))}


def records(data):
    """(opcode, start, end) of every record of an MCAP file (specification: opcode, u64 length)."""
    at = 8
    while at < len(data) - 8:
        opcode, length = struct.unpack_from('<BQ', data, at)
        yield opcode, at, at + 9 + length
        at += 9 + length


def test_a_stretch_cut_out_cleanly_together_with_the_count_is_stated(tmp_path, bags):
    data = bags['lz4.mcap'].read_bytes()
    found = list(records(data))
    last = max(i for i, r in enumerate(found) if r[0] == CHUNK)
    gone = [r for i, r in enumerate(found)
            if r[0] == STATISTICS or (i >= last and r[0] in (CHUNK, MESSAGE_INDEX))]
    kept = bytearray(data)
    for _, start, end in reversed(gone):
        del kept[start:end]
    (tmp_path / 'cut.mcap').write_bytes(kept)
    with Bag(str(tmp_path / 'cut.mcap')) as bag:
        count = sum(len(block) for block in bag.blocks())
        assert 0 < count < 101
        assert 'bytes are missing' in bag.loss.text()
    with Bag(str(bags['lz4.mcap'])) as bag:
        assert sum(len(block) for block in bag.blocks()) == 101 and not bag.loss


@pytest.mark.parametrize('new', [b'tion_hash `TEXT', b'tion_ha\n(\n TEXT',
                                 b'tion_hash `\xa0\n T'])
def test_damaged_table_definitions_are_refused_in_one_line(tmp_path, bags, new):
    old = b'tion_hash TEXT NOT'
    data = next(p for n, p in bags.items() if n.endswith('.db3')).read_bytes()
    assert old in data
    (tmp_path / 'a.db3').write_bytes(data.replace(old, new.ljust(len(old))))
    with pytest.raises(BagError) as error, Bag(str(tmp_path / 'a.db3')) as bag:
        list(bag.blocks())
    assert '\n' not in str(error.value)
