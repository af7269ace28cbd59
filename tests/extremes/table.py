#!/usr/bin/env python3
"""Remakes the tables of docs/extremes.md from what the extremes find: the tests say `found | TABLE | COLUMN | …`.

Usage: tests/extremes/table.py BUILD [--long] [--write docs/extremes.md] [--only SUITE,…]
BUILD is a build directory with tests (build/ci). Without --write the tables are printed. The page keeps its text; what
stands between `<!-- NAME -->` and `<!-- end -->` is replaced if this run found rows for NAME."""

import argparse
import os
import pathlib
import re
import subprocess
import sys

ROOT = pathlib.Path(__file__).resolve().parents[2]
SUITES = "Heavy Stacks Radii Friction Cohesion Scales Speeds ClosingWalls Degenerate Rest".split()
CASES = "Origin Ranks Refusals Pile".split()

HEADS = {
    "heavy in time": ["scene", "mass ratio", "largest overlap / r", "heavy one sank / r", "force error after 1 s"],
    "heavy tight": ["scene", "mass ratio", "sweeps a step", "largest residual", "force error of the first step",
                    "largest of all steps", "over the largest residual", "overlap / r"],
    "stacks": ["disks", "sweeps to 1e-6", "over those of a decade", "residual", "force error / weight"],
    "stacks in time": ["disks", "overlap / r", "force error after 1 s"],
    "radii": ["radius ratio", "mass ratio", "sweeps", "residual", "force error / weight"],
    "small on large": ["radius ratio", "largest overlap / r", "largest energy / that at the start", "refused"],
    "box": ["mu", "e", "energy at the end", "largest", "largest gain in a step", "refused"],
    "cohesion": ["gamma [N]", "largest overlap / r", "spread / 2 r", "energy gained / (gamma d_w)", "refused"],
    "steps": ["h [s]", "overlap / r", "force error", "refused"],
    "fall": ["h [s]", "overlap / r"],
    "gravity": ["g [m/s²]", "h [s]", "overlap / r", "force error", "refused"],
    "density": ["density [kg/m³]", "residual", "force error"],
    "near miss": ["distance / 2 r", "radii per step", "speed lost"],
    "one behind the other": ["e", "radii per step", "largest overlap / r", "refused"],
    "closing walls": ["speed of each [m/s]", "disks", "sweeps", "steps done", "told"],
    "line": ["e", "phase", "v of the first", "second", "third"],
    "crystal": ["mu", "sum of wall forces along x / weight", "along y - 1", "moved / r"],
    "rest": ["steps", "moved / r", "turned [rad]", "kinetic [J]"],
    "origin": ["shift [m]", "ranks", "same hash as at 0"],
    "ranks": ["world", "ranks", "found"],
    "refusals": ["case", "exit code", "said"],
    "pile": ["grains", "contacts", "largest overlap / r", "on 1 and 2 ranks"],
}


def collect(build, long_form, only):
    """Table -> list of rows; the tests' own verdicts go to the terminal."""
    commands = []
    for suite in SUITES:
        if not only or suite in only:
            program = [build / "tests/extremes/test.extremes", f"--gtest_filter={suite}.*"]
            commands.append([ROOT / "tools/mpirun", "-n", "1", *program])
    for case in CASES:
        if not only or case in only:
            program = ROOT / "tests/extremes/program_test.py"
            commands.append([sys.executable, program, "--nappe", build / "nappe", "--mpirun", ROOT / "tools/mpirun", case])
    environment = dict(os.environ, NAPPE_YIELD="1", NAPPE_EXTREMES="long" if long_form else "short")
    tables, failed = {}, False
    for command in commands:
        print("running", command[-1], file=sys.stderr, flush=True)
        done = subprocess.run([str(c) for c in command], env=environment, capture_output=True, text=True)
        failed = failed or done.returncode != 0
        if done.returncode != 0:
            print(done.stdout, done.stderr, file=sys.stderr)
        for line in (done.stdout + done.stderr).splitlines():
            row = re.search(r"found \| (.*) \|$", line)
            if row:
                name, *columns = [cell.strip() for cell in row.group(1).split("|")]
                tables.setdefault(name, []).append(columns)
    return tables, failed


def markdown(head, rows):
    # A last column in which no row says anything is left out.
    while head and all(not row[len(head) - 1 :] or not row[len(head) - 1] for row in rows):
        head = head[:-1]
    rows = [row + [""] * (len(head) - len(row)) for row in rows]
    lines = ["| " + " | ".join(head) + " |", "| " + " | ".join("---" for _ in head) + " |"]
    return "\n".join(lines + ["| " + " | ".join(row[: len(head)]) + " |" for row in rows])


def heavy(rows):
    """Scene and ratio down, sweeps across: residual and force error of each; and the largest factor between them."""
    sweeps = sorted({int(row[2]) for row in rows})
    cells, factor = {}, {}
    for scene, ratio, n, residual, error, quotient in rows:
        cells.setdefault((scene, ratio), {})[int(n)] = f"{residual}, {error}"
        factor[scene, ratio] = max(factor.get((scene, ratio), 0.0), float(quotient or 0))
    head = ["scene", "mass ratio", *(f"{n} sweeps" for n in sweeps), "largest factor"]
    body = []
    for (scene, ratio), found in cells.items():
        largest = factor[scene, ratio]
        body.append([scene, ratio, *(found.get(n, "") for n in sweeps), f"{largest:.3g}" if largest else ""])
    return markdown(head, body)


def solvers(rows):
    """Scene and ratio down, solvers across: sweeps, or the residual where they ran out, and the force error."""
    methods = list(dict.fromkeys(row[0] for row in rows))
    cells = {}
    for method, scene, ratio, sweeps, residual, error, converged in rows:
        told = sweeps if converged else f"({residual})"
        cells.setdefault((scene, ratio), {})[method] = f"{told}, {error}"
    head = ["scene", "mass ratio", *methods]
    return markdown(head, [[*key, *(found.get(m, "") for m in methods)] for key, found in cells.items()])


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("build", type=pathlib.Path)
    parser.add_argument("--long", action="store_true")
    parser.add_argument("--write", type=pathlib.Path)
    parser.add_argument("--only", default="")
    options = parser.parse_args()
    tables, failed = collect(options.build.resolve(), options.long, [s for s in options.only.split(",") if s])
    page = options.write.read_text() if options.write else ""
    for name, rows in tables.items():
        pivots = {"heavy": heavy, "solvers": solvers}
        text = pivots[name](rows) if name in pivots else markdown(HEADS[name], rows)
        if not options.write:
            print(f"\n{name}\n\n{text}")
            continue
        page, n = re.subn(
            rf"<!-- {name} -->.*?<!-- end -->", lambda _: f"<!-- {name} -->\n{text}\n<!-- end -->", page, flags=re.S
        )
        if n != 1:
            print(f"{options.write} has {n} places for the table '{name}'", file=sys.stderr)
            failed = True
    if options.write:
        options.write.write_text(page)
    sys.exit(1 if failed else 0)


if __name__ == "__main__":
    main()
