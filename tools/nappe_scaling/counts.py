"""Reads what `nappe partitions --json` wrote."""

import json

import numpy as np

COLOURS = 4


class BadCounts(Exception):
    """The file is not what `nappe partitions --json` writes."""


class Cut:
    """A sample cut into `parts`: arrays over parts (rows) and tile colours (columns), and the messages of a sweep."""

    def __init__(self, cut, grain_bytes):
        self.parts = cut["parts"]
        self.cut_seconds = cut["cut_seconds"]
        self.grains = np.array(cut["grains"], float)
        self.interface = np.array(cut["interface"], float)
        self.interior = np.array(cut["interior"], float)
        messages = cut["messages"]
        self.sender = np.array(messages["from"], int)
        self.receiver = np.array(messages["to"], int)
        self.colour = np.array(messages["colour"], int)
        self.bytes = grain_bytes * np.array(messages["grains"], float)

    @property
    def relaxations(self):
        return (self.interface + self.interior).sum(axis=1)

    @property
    def imbalance(self):
        return self.relaxations.max() / max(self.relaxations.mean(), 1e-300)

    def per_part(self, end, values=None):
        """Sum over the messages of each part (`end`: sender or receiver) and colour; of ones, their number."""
        table = np.zeros((self.parts, COLOURS))
        np.add.at(table, (end, self.colour), 1.0 if values is None else values)
        return table


class Sample:
    """One way of counting one sample, for several numbers of parts."""

    def __init__(self, sample, tile_side, grain_bytes):
        self.level = sample["level"]
        self.scale = sample["scale"]
        self.grains = sample["grains"]
        self.relaxations = sample["relaxations"]
        self.tiles = sample["tiles"]
        self.tile_side = tile_side
        self.cuts = {cut["parts"]: Cut(cut, grain_bytes) for cut in sample["cuts"]}


def read(path):
    """The samples of a file, in its order."""
    try:
        with open(path) as file:
            data = json.load(file)
        return [Sample(s, data["tile_side"], data["bytes_per_grain"]) for s in data["counts"]]
    except (OSError, ValueError, KeyError, TypeError) as error:
        raise BadCounts(f"{path} holds no counts of nappe partitions: {error!r}") from error
