"""tools/scaling_model: predicts strong and weak scaling from counts of real partitions."""

import argparse
import json
import subprocess
import sys
from pathlib import Path

from nappe_plot import style

from . import counts, machine, model, report
from .cases import CASES, make_counts


def names(text):
    chosen = text.split(",")
    unknown = [name for name in chosen if name not in {case.name for case in CASES}]
    if unknown:
        known = ", ".join(case.name for case in CASES)
        raise argparse.ArgumentTypeError(f'no case "{unknown[0]}"; there are {known}')
    return chosen


def rows_of(case, folder, chosen, sweeps):
    rows = []
    for name, _, index in case.runs:
        sample = counts.read(folder / f"{name}.json")[index]
        for cut in sample.cuts.values():
            if cut.parts >= case.least:
                rows.append(report.Row(sample, cut, model.sweep(cut, chosen), model.step(cut, chosen, sweeps)))
    return rows


def say_case(case, arguments, chosen):
    rows = rows_of(case, arguments.counts, chosen, arguments.sweeps)
    print(f"\n### {case.title[0].upper()}{case.title[1:]}\n\n{report.table(rows, case.weak)}\n")
    print(report.half_point(rows, case.weak))
    if arguments.pictures:
        path = report.picture(rows, case, chosen, arguments.pictures / f"scaling-{case.name}.png")
        print(f"\n![{case.title}]({path.parent.name}/{path.name})")
    name, _, index = case.runs[0]
    samples = counts.read(arguments.counts / f"{name}.json")
    if index == 0 and len(samples) > 1:
        print(f"\nCounted by tiles against counted by grains:\n\n{report.error_by_tiles(samples[0], samples[1])}")


def main():
    parser = argparse.ArgumentParser(prog="tools/scaling_model", description="Predicts scaling from counts.")
    parser.add_argument("--counts", type=Path, default=Path("out/scaling"), help="folder of the counts (out/scaling)")
    parser.add_argument("--nappe", help="the program that makes the counts which are not there yet")
    parser.add_argument("--machine", default="cluster", help="cluster, here, or a file like theirs (cluster)")
    parser.add_argument("--bench", type=Path, help="costs of relaxations, steps and lists from nappe bench --json FILE")
    parser.add_argument("--speed-up", type=float, default=1.0, help="relaxations in cache so many times faster (1)")
    parser.add_argument("--sweeps", type=int, default=100, help="of a step (100)")
    parser.add_argument("--cases", type=names, default=[case.name for case in CASES], help="some, with commas between")
    parser.add_argument("--pictures", type=Path, help="folder for a picture a case")
    parser.add_argument("--fit", type=Path, help="print what fits the times of benchmark.ping_pong")
    arguments = parser.parse_args()
    try:
        if arguments.fit:
            latency, bandwidth, overhead = machine.fit_messages(json.loads(arguments.fit.read_text()))
            print(f"latency {latency:.3g} s, bandwidth {bandwidth:.3g} B/s, overhead {overhead:.3g} s")
            return 0
        chosen = machine.read(arguments.machine)
        if arguments.bench:
            chosen = machine.with_bench(chosen, arguments.bench)
        if not arguments.speed_up > 0:
            raise ValueError(f"--speed-up must be > 0, found {arguments.speed_up}; 2 halves the time of a relaxation")
        chosen.relaxation = [[size, ns / arguments.speed_up] for size, ns in chosen.relaxation]
        style.apply()
        for case in CASES:
            if case.name in arguments.cases:
                if arguments.nappe:
                    make_counts(case, arguments.counts, arguments.nappe)
                say_case(case, arguments, chosen)
    except (counts.BadCounts, machine.BadMachine, OSError, ValueError) as error:
        sys.exit(f"scaling_model: {error}")
    except subprocess.CalledProcessError as error:
        sys.exit(f"scaling_model: nappe partitions ended with exit code {error.returncode}; its message is above")
    return 0


if __name__ == "__main__":
    sys.exit(main())
