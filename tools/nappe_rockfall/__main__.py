"""tools/rockfall_study: runs the study and reports it."""

import argparse
import fnmatch
import os
import subprocess
import sys
from pathlib import Path

from . import pictures, plan, report
from .results import Result

ROOT = Path(__file__).resolve().parents[2]


def parse():
    parser = argparse.ArgumentParser(prog="tools/rockfall_study", description=__doc__)
    parser.add_argument("command", choices=["list", "run", "report"])
    parser.add_argument("--out", type=Path, default=Path("out/rockfall"), help="a folder a run goes here (out/rockfall)")
    parser.add_argument("--nappe", type=Path, default=ROOT / "build/release/nappe", help="the program")
    parser.add_argument("--only", default="*", help="pattern of the names of runs")
    parser.add_argument("--page", type=Path, help="put the tables into this page too (docs/rockfall.md)")
    parser.add_argument("--pictures", type=Path, help="where the report's pictures go (OUT/pictures)")
    return parser.parse_args()


def run(planned, arguments):
    """Runs it if it is not done; a scene that fails numerically is a result too."""
    folder = arguments.out / planned.name
    if (folder / "said.txt").exists():
        print(f"{planned.name}: done before", flush=True)
        return
    sets = [word for key, value in planned.keys.items() for word in ("--set", f"{key}={value}")]
    command = [arguments.nappe, "run", planned.scene, "--out", folder, "--samples", arguments.out / "samples", "--overwrite", *sets]
    done = subprocess.run(command, capture_output=True, text=True)
    if done.returncode not in (0, 4):
        sys.exit(f"rockfall_study: {planned.name}: exit code {done.returncode}\n{done.stderr}")
    (folder / "said.txt").write_text(done.stderr + f"exit code {done.returncode}\n")
    print(f"{planned.name}: exit code {done.returncode}", flush=True)


def main():
    arguments = parse()
    runs = [one for one in plan.planned() if fnmatch.fnmatch(one.name, arguments.only)]
    if arguments.command == "list":
        for one in runs:
            print(one.name, one.scene.name, *(f"{key}={value}" for key, value in one.keys.items()))
    elif arguments.command == "run":
        if not os.access(arguments.nappe, os.X_OK):
            sys.exit(f"rockfall_study: {arguments.nappe} is not there; build it (cmake --preset release) or give --nappe")
        for one in runs:
            run(one, arguments)
    else:
        known = {one.name: Result(arguments.out / one.name) for one in runs if (arguments.out / one.name / "said.txt").exists()}
        known = {name: result for name, result in known.items() if result.probe is not None}
        made = report.tables(known)
        for name, lines in made.items():
            print(f"{name}:", *lines, sep="\n")
        if arguments.page:
            arguments.page.write_text(report.put_into(arguments.page.read_text(), made))
        for path in pictures.pictures(known, arguments.pictures or arguments.out / "pictures"):
            print(path)


if __name__ == "__main__":
    main()
