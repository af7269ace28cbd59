"""The cases of docs/scaling.md and how their counts are made by `nappe partitions`."""

import dataclasses
import subprocess
import sys
from pathlib import Path

FOLD = Path(__file__).resolve().parents[2] / "jobs" / "fold.toml"
FOLD_GRAINS = 42314
BASE = 2.0  # lengths of the sample whose tiles stand for those of weak scaling: 170,000 grains
WEAK_PARTS = [1, 2, 8, 64, 512, 4096]


@dataclasses.dataclass
class Case:
    """A picture and a table. Each of `runs`: JSON's name, arguments of nappe partitions, index of the sample in it."""

    name: str
    title: str
    runs: list
    weak: bool = False
    least: int = 1  # ranks of the first row, against which efficiency counts


def _lengths(grains):
    """How much longer than the fold a sample of so many grains is."""
    return (grains / FOLD_GRAINS) ** 0.5


def _weak(per_rank):
    runs = []
    for parts in WEAK_PARTS:
        scale = _lengths(parts * per_rank) / BASE
        arguments = ["--scale", f"{BASE:g}", "--tile-scale", f"{scale:.6g}", "--parts", str(parts)]
        runs.append((f"weak-{per_rank}-{parts}", arguments, 2))
    return runs


_MILLION = ["--scale", f"{_lengths(1e6):.6g}"]
_SMALL_TILES = ["--set", "tiles.side=4.5"]  # m; half the default

CASES = [
    Case("fold", "the fold, 42,314 grains", [("fold", ["--tile-scale", "1"], 0)]),
    Case("fold-small-tiles", "the fold on tiles of 4.5 m", [("fold-small-tiles", _SMALL_TILES, 0)]),
    Case("1m", "the fold scaled to 1 million grains", [("1m", [*_MILLION, "--tile-scale", "10"], 0)]),
    Case("1m-small-tiles", "1 million grains on tiles of 4.5 m", [("1m-small-tiles", [*_MILLION, *_SMALL_TILES], 0)]),
    # From one full node on: a single rank would have all of a node's memory for itself.
    Case(
        "100m",
        "the fold scaled to 100 million grains, counted by tiles",
        [("1m", [*_MILLION, "--tile-scale", "10"], 2)],
        least=64,
    ),
    Case("weak-10k", "10,000 grains per rank, counted by tiles", _weak(10000), weak=True),
    Case("weak-43k", "43,000 grains per rank, counted by tiles", _weak(43000), weak=True),
]


def make_counts(case, folder, nappe):
    """Runs `nappe` for what the folder does not have yet."""
    folder.mkdir(parents=True, exist_ok=True)
    for name, arguments, _ in case.runs:
        path = folder / f"{name}.json"
        if not path.exists():
            command = [nappe, "partitions", str(FOLD), *arguments, "--json", str(path)]
            subprocess.run(command, check=True, stdout=sys.stderr)  # stdout is the report's
