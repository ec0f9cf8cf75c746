"""Which view of a data set is what: scenes, then conditions, then sets of poses, in one row.

All eyes have the same views. A shard is the views that are made, written and recorded together; a
chunk, what is read at once. Shards need not end where a scene does.
"""

from __future__ import annotations

from dataclasses import dataclass

from omma._core import Error
from omma.datasets.job_file import Job

# In a shard of all variables, and in a chunk of one, before they are compressed.
_SHARD_BYTES = 32 << 20
_CHUNK_BYTES = 1 << 18
# Their coordinates, some hundred bytes each, are in memory while a store is begun.
MOST_VIEWS = 50_000_000
# A kill loses at most a shard; slow renders have small ones.
_MOST_VIEWS_PER_SHARD = 1024


@dataclass(frozen=True)
class Block:
    """Views in a row of one scene, condition and set of poses, by their indices in the job."""

    first: int
    count: int
    scene: int
    condition: int
    poses: int


@dataclass(frozen=True)
class Plan:
    """The views of a job, and how they are divided."""

    blocks: tuple[Block, ...]
    views: int
    views_per_chunk: int
    views_per_shard: int

    @property
    def shards(self) -> int:
        """How many there are."""
        return -(-self.views // self.views_per_shard)

    def views_of(self, shard: int) -> range:
        """The views of a shard."""
        first = shard * self.views_per_shard
        return range(first, min(first + self.views_per_shard, self.views))

    def parts_of(self, views: range) -> list[tuple[Block, range]]:
        """The blocks that views lie in, and which views of each these are, by their number in the
        data set."""
        found = []
        for block in self.blocks:
            first = max(views.start, block.first)
            stop = min(views.stop, block.first + block.count)
            if first < stop:
                found.append((block, range(first, stop)))
        return found


def make_plan(job: Job, view_bytes: tuple[int, int]) -> Plan:
    """The plan of a job; ``view_bytes`` are those of a view of the largest eye, and of the largest
    of its variables."""
    in_shard, in_chunk = view_bytes
    blocks, first = [], 0
    for s, scene in enumerate(job.scenes):
        for c in range(len(job.conditions)):
            for p, poses in enumerate(job.poses):
                if scene.name in poses.scenes:
                    blocks.append(Block(first, poses.count, s, c, p))
                    first += poses.count
    if not blocks:
        raise Error("poses: expected some in at least one of the scenes, found none")
    if first > MOST_VIEWS:
        raise Error(
            f"poses: expected at most {MOST_VIEWS:,} views in one data set, whose coordinates fit "
            f"in memory, found {first:,}; make several"
        )
    chunk = job.views_per_chunk or _power_of_two(_CHUNK_BYTES // in_chunk, 256)
    shard = job.views_per_shard or max(
        chunk, _power_of_two(_SHARD_BYTES // in_shard, _MOST_VIEWS_PER_SHARD)
    )
    if shard % chunk:
        raise Error(
            f"views_per_shard: expected a multiple of views_per_chunk ({chunk}), found {shard}"
        )
    return Plan(tuple(blocks), first, chunk, shard)


def _power_of_two(number: int, most: int) -> int:
    """The largest that is at most both, at least 1."""
    return 1 << max(0, min(number, most).bit_length() - 1)
