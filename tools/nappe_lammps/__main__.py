"""nappe beside LAMMPS on one core: see tools/compare-lammps."""

import argparse
import itertools
import json
import math
import os
import pathlib
import re
import shutil
import statistics
import subprocess
import sys
import tomllib

from nappe_lammps.packing import Packing

ROOT = pathlib.Path(__file__).resolve().parents[2]


def parse():
    parser = argparse.ArgumentParser(prog="compare-lammps", description=__doc__)
    parser.add_argument("scenes", nargs="*", type=pathlib.Path, default=[ROOT / "jobs/rockfall-cost.toml"],
                        help="scenes whose last stage is smooth [jobs/rockfall-cost.toml]")
    parser.add_argument("--grains", help="sizes, by commas: each scene is widened to hold about so many")
    parser.add_argument("--nappe", required=True, help="the program")
    parser.add_argument("--lammps", default="lmp", help="the other one [lmp]")
    parser.add_argument("--rounds", type=int, default=5, help="turns of each [5]")
    parser.add_argument("--seconds", type=float, default=2.0, help="about so long a turn [2]")
    parser.add_argument("--core", type=int, default=os.cpu_count() - 1, help="both are bound to this one [the last]")
    parser.add_argument("--out", type=pathlib.Path, default=pathlib.Path("out/compare-lammps"), help="work folder")
    parser.add_argument("--json", type=pathlib.Path, help="write the figures to this file too")
    return parser.parse_args()


class Runner:
    """Runs both on one core, and tells the processor's seconds that they took: what else the machine does counts less."""

    def __init__(self, args):
        self.args = args

    def seconds(self, *command):
        command = ["taskset", "-c", str(self.args.core), *map(str, command)]
        process = subprocess.Popen(command, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True)
        said = process.stdout.read()
        _, status, usage = os.wait4(process.pid, 0)
        if status != 0:
            sys.exit(f"compare-lammps: {' '.join(command)} failed:\n{said[-2000:]}")
        return usage.ru_utime + usage.ru_stime, said

    def nappe(self, scene, folder, steps):
        # The sample is in the store; series and frames once, as LAMMPS prints once.
        often = f"{10 * steps + 10}"
        took, _ = self.seconds(
            self.args.nappe, "run", scene, "--out", folder / "nappe", "--samples", folder / "samples", "--overwrite",
            "--steps", steps, "--set", f"output.series.every={often}", "--set", f"output.frames.every={often}",
            "--set", "stages.weight.duration=1000")
        return took

    def lammps(self, folder, packing, steps, **settings):
        script = folder / "in.packing"
        script.write_text(packing.script(folder / "packing.data", steps, **settings))
        return self.seconds(self.args.lammps, "-in", script, "-log", folder / "log.lammps", "-screen", "none")[0]


def per_step(run, few, many):
    """Seconds of a step: what it takes to start and end is in both."""
    return (run(many) - run(few)) / (many - few)


def steps_for(run, seconds):
    few = 20
    many = few
    while many < 1_000_000:
        many *= 4
        step = per_step(run, few, many)
        if step * many > 0.25 * seconds:
            return few, few + max(100, int(seconds / step))
    return few, many


def tune(runner, folder, packing, steps):
    """What LAMMPS is quickest with: skin, newton, bins, how often it asks whether lists last."""
    largest = packing.radius.max()
    found = {}
    for newton, binning, share, every in itertools.product(("off", "on"), ("bin", "multi"), (0.1, 0.3, 0.6), (1, 10)):
        settings = {"newton": newton, "binning": binning, "skin": share * largest, "every": every}
        try:
            found[json.dumps(settings)] = runner.lammps(folder, packing, steps, **settings)
        except SystemExit as error:
            print(f"compare-lammps: LAMMPS refuses {settings}: {str(error).splitlines()[-1]}", file=sys.stderr)
    return json.loads(min(found, key=found.get))


def widened(scene, grains, folder):
    """The scene with a box as wide as so many grains need, by the grains' mean area and the pores of a deposit."""
    text = scene.read_text()
    keys = tomllib.loads(text)["sample"]
    low, high = keys["radius"]["min"], keys["radius"]["max"]
    width = max(x for x, _ in keys["profile"])
    depth = max(y for _, y in keys["profile"])
    area = math.pi * (low * low + low * high + high * high) / 3
    solid = 1.03  # of the mean disk: small ones fill the gaps of a deposit
    new = grains * area / (solid * depth)
    path = folder / f"{scene.stem}-{grains}.toml"
    path.write_text(re.sub(rf"\[{width:g},", f"[{new:.6g},", text))
    return path


def compare(args, scene):
    folder = args.out / scene.stem
    folder.mkdir(parents=True, exist_ok=True)
    runner = Runner(args)
    runner.nappe(scene, folder, 1)
    frame = folder / "nappe/frames/frame-00000000.hdf"
    packing = Packing(frame, scene)
    (folder / "packing.data").write_text(packing.data())
    few, many = steps_for(lambda n: runner.lammps(folder, packing, n, newton="off", binning="bin",
                                                  skin=0.3 * packing.radius.max(), every=1), 0.5 * args.seconds)
    settings = tune(runner, folder, packing, many)
    turns = {
        "nappe": lambda n: runner.nappe(scene, folder, n),
        "LAMMPS": lambda n: runner.lammps(folder, packing, n, **settings),
    }
    steps = {name: steps_for(run, args.seconds) for name, run in turns.items()}
    seconds = {name: [] for name in turns}
    for _ in range(args.rounds):
        for name, run in turns.items():
            seconds[name].append(per_step(run, *steps[name]))
    dangerous = re.search(r"Dangerous builds = (\d+)", (folder / "log.lammps").read_text())
    summary = json.loads((folder / "nappe/summary.json").read_text())
    grains = summary["grains"]
    contacts = summary["relaxations"] / summary["steps"]
    ratios = [b / a for a, b in zip(seconds["nappe"], seconds["LAMMPS"])]
    rows = {name: {"ns_per_contact_step": 1e9 * statistics.median(s) / contacts,
                   "grain_steps_per_second": grains / statistics.median(s)} for name, s in seconds.items()}
    return {"scene": scene.stem, "grains": grains, "contacts": round(contacts), "kernel": summary["kernel"],
            "steps": {name: many - few for name, (few, many) in steps.items()}, "lammps": settings,
            "dangerous_builds": int(dangerous.group(1)) if dangerous else None, **rows,
            "ratio": statistics.median(ratios), "ratio_least": min(ratios), "ratio_most": max(ratios)}


def main():
    args = parse()
    if shutil.which(args.lammps) is None:
        sys.exit(f"compare-lammps: {args.lammps} is not there: run tools/setup comparing, or name it with --lammps")
    results = []
    print("| grains | contacts | nappe: ns a contact | grain-steps/s | LAMMPS: ns a contact | grain-steps/s | ratio "
          "(least–most) | LAMMPS with |\n| ---: | ---: | ---: | ---: | ---: | ---: | --- | --- |", flush=True)
    scenes = args.scenes
    if args.grains:
        args.out.mkdir(parents=True, exist_ok=True)
        scenes = [widened(scene, int(n), args.out) for scene in scenes for n in args.grains.split(",")]
    for scene in scenes:
        r = compare(args, scene)
        results.append(r)
        a, b, s = r["nappe"], r["LAMMPS"], r["lammps"]
        print(f"| {r['grains']} | {r['contacts']} | {a['ns_per_contact_step']:.1f} | {a['grain_steps_per_second']:.3g} "
              f"| {b['ns_per_contact_step']:.1f} | {b['grain_steps_per_second']:.3g} | {r['ratio']:.2f} "
              f"({r['ratio_least']:.2f}–{r['ratio_most']:.2f}) | newton {s['newton']}, skin {1e3 * s['skin']:.3g} mm, "
              f"{s['binning']}, every {s['every']} |", flush=True)
        if args.json:
            args.json.write_text(json.dumps(results, indent=2) + "\n")


main()
