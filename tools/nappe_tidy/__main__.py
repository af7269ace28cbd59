"""tools/tidy: clang-tidy over several sources at a time.

clang-tidy 14 searches all headers of a source for its patterns, the system's too: of 26 s for one of our files 3 s are the
compiler's and 18 s that search. So sources that are compiled alike are looked at together, up to MOST in one unit that
includes them, and the headers they share are searched once. The static analyser follows sources included by the main file
as if they were it. Where names of two sources of a unit clash (each has its own anonymous namespace, or both instantiate
the same template), the later one goes to another unit.
"""

import argparse
import collections
import json
import multiprocessing.pool
import os
import pathlib
import re
import shlex
import subprocess
import sys
import time

MOST = 8  # sources in a unit
HEAD = re.compile(r"^(/[^:\n]+):(\d+):(\d+): (warning|error): .*\[[\w.,-]+\]$")
TIDY = "clang-tidy-14"


class Broken(Exception):
    """clang-tidy could not do its work."""


def tidy(source, flags, *options):
    """Blocks of lines, each a finding with what belongs to it."""
    command = [TIDY, "--quiet", *options, str(source), "--", *flags, "-ferror-limit=0"]
    result = subprocess.run(command, capture_output=True, text=True)
    blocks = []
    for line in result.stdout.splitlines():
        if HEAD.match(line):
            blocks.append([line])
        elif blocks:
            blocks[-1].append(line)
    if result.returncode != 0 and not blocks:
        raise Broken(f"{shlex.join(command)} ended with {result.returncode}:\n{result.stdout}{result.stderr}")
    return blocks


def place(block):
    return pathlib.Path(HEAD.match(block[0])[1])


class Unit:
    def __init__(self, folder, name, flags, sources):
        self.path = folder / f"{name}.cpp"
        self.flags = flags
        self.sources = sources

    def write(self):
        self.path.write_text("".join(f'#include "{source}"\n' for source in self.sources))

    def clashing(self):
        """Sources, past the first, that do not compile after those before them. A cheap check alone: the compiler's."""
        if len(self.sources) == 1:
            return []
        self.write()
        blocks = tidy(self.path, self.flags, "--checks=-*,misc-new-delete-overloads")
        wrong = {place(block) for block in blocks if "[clang-diagnostic-error]" in block[0]}
        if wrong and not wrong & set(self.sources[1:]):
            return self.sources[1:]  # something the first one brought disturbs a header
        return [source for source in self.sources[1:] if source in wrong]

    def findings(self):
        self.write()
        return [block for block in tidy(self.path, self.flags) if place(block) != self.path]


def by_flags(commands, wanted):
    """Flags -> sources that are compiled with them."""
    groups = collections.defaultdict(list)
    for entry in json.loads(commands.read_text()):
        source = pathlib.Path(entry["file"]).resolve()
        if source in wanted:
            words = shlex.split(entry["command"])
            del words[words.index("-o") : words.index("-o") + 2]
            del words[words.index("-c") : words.index("-c") + 2]
            groups[tuple(words[1:])].append(source)
            wanted.discard(source)
    if wanted:
        names = ", ".join(sorted(map(str, wanted)))
        raise Broken(f"files must be sources (.cpp) of a target of the preset ci, found {names}; headers come with them")
    return groups


def divide(folder, pool, groups):
    """Units without clashes, the largest first. Neighbours in the alphabet, alike as a rule, go to different units."""
    units, waiting = [], []
    for flags, sources in groups.items():
        n_units = -(-len(sources) // MOST)
        waiting += [(flags, sorted(sources)[k::n_units]) for k in range(n_units)]
    while waiting:
        tried = [Unit(folder, f"unit-{len(units) + k}", *these) for k, these in enumerate(waiting)]
        waiting = []
        for unit, out in zip(tried, pool.map(Unit.clashing, tried, chunksize=1)):
            unit.sources = [source for source in unit.sources if source not in out]
            if out:
                waiting.append((unit.flags, out))
        units += tried
    return sorted(units, key=lambda unit: -sum(source.stat().st_size for source in unit.sources))


def run(options):
    began = time.monotonic()
    folder = options.root / "build" / "tidy"
    folder.mkdir(parents=True, exist_ok=True)
    wanted = {path.resolve() for path in options.files or (options.root / "src").rglob("*.cpp")}
    n_files = len(wanted)
    with multiprocessing.pool.ThreadPool(len(os.sched_getaffinity(0))) as pool:
        units = divide(folder, pool, by_flags(options.commands, wanted))
        divided = time.monotonic()
        found = {}
        for blocks in pool.imap_unordered(Unit.findings, units):
            for block in blocks:  # one in a header comes with every unit
                if found.setdefault(block[0], block) is block:
                    print("\n".join(block), flush=True)
    print(
        f"tidy: {n_files} files in {len(units)} units, {len(found)} findings; "
        f"{divided - began:.0f} s to divide, {time.monotonic() - divided:.0f} s to look",
        file=sys.stderr,
    )
    return 1 if found else 0


def main():
    parser = argparse.ArgumentParser(prog="tools/tidy", description="clang-tidy over src; exit code 1 with findings")
    parser.add_argument("--root", type=pathlib.Path, required=True, help=argparse.SUPPRESS)
    parser.add_argument("--commands", type=pathlib.Path, required=True, help=argparse.SUPPRESS)
    parser.add_argument("files", nargs="*", type=pathlib.Path, metavar="FILE", help="sources [all of src]")
    try:
        sys.exit(run(parser.parse_args()))
    except Broken as failure:
        sys.exit(f"tidy: {failure}")


main()
