"""tools/fault_study: runs the parametric study of fault propagation, measures it and reports on it."""

import argparse
import fnmatch
import shlex
import sys
from pathlib import Path

from . import plan, runner

STOPPED_EARLY = 3  # exit code, as that of nappe


def chosen_runs(arguments):
    """Those that --index and --only leave; an error if that is none."""
    study = plan.QUICK if arguments.quick else plan.FULL
    runs = study.runs()
    if arguments.index is not None:
        runs = [run for run in runs if run.sample == arguments.index]
    if arguments.only:
        runs = [run for run in runs if fnmatch.fnmatchcase(run.name, arguments.only)]
    if not runs:
        n = len(study.samples())
        sys.exit(
            f"fault_study: --only {arguments.only} and --index {arguments.index} leave no run; `fault_study list` has "
            f"the names, and samples are numbered from 0 to {n - 1}"
        )
    return runs


def list_runs(arguments):
    for run in chosen_runs(arguments):
        done = "done" if runner.is_done(run, arguments.out) else "to do"
        command = run.command(arguments.nappe, arguments.out, arguments.scene)
        print(f"# {run.sample} {run.name}: {done}\n{shlex.join(command)}")
    return 0


def run_all(arguments):
    runs = chosen_runs(arguments)
    missing = [run for run in runs if not runner.is_done(run, arguments.out)]
    print(f"{len(runs) - len(missing)} of {len(runs)} runs are done", flush=True)

    def command_of(run):
        return run.command(arguments.nappe, arguments.out, arguments.scene)

    return finish(runner.Scheduler(missing, arguments.jobs, arguments.out, command_of))


def finish(scheduler):
    """Runs it; the exit code."""
    failed = scheduler.run()
    if scheduler.stopped:
        print("stopped; run the same command again to go on", flush=True)
        return STOPPED_EARLY
    if failed:
        print(f"{len(failed)} runs failed: {', '.join(failed)}", flush=True)
    return 1 if failed else 0


def at_least_one(text):
    if not text.isdecimal() or int(text) < 1:
        raise argparse.ArgumentTypeError(f'a whole number from 1 on is wanted; found "{text}"')
    return int(text)


def parser_of():
    common = argparse.ArgumentParser(add_help=False)
    files = {"type": Path, "metavar": "PATH"}
    common.add_argument("--out", **files, default=Path("out/fault-study"), help="of the runs (out/fault-study)")
    common.add_argument("--nappe", **files, default=Path("build/release/nappe"), help="(build/release/nappe)")
    common.add_argument("--scene", **files, default=plan.SCENE, help="which the runs vary (jobs/fault.toml)")
    common.add_argument("--only", metavar="PATTERN", help="runs whose name matches: 'theta30-h15-*'")
    common.add_argument("--index", type=int, metavar="N", help="only the runs of sample N (the number in `list`)")
    common.add_argument("--quick", action="store_true", help="eight small short runs instead, to try the tool")
    jobs = argparse.ArgumentParser(add_help=False)
    jobs.add_argument("--jobs", type=at_least_one, default=2, help="runs at a time, one rank each (2)")
    parser = argparse.ArgumentParser(prog="tools/fault_study", description=__doc__.split(": ", 1)[1])
    commands = parser.add_subparsers(required=True, metavar="COMMAND")

    def add(name, function, parents, text):
        command = commands.add_parser(name, parents=parents, help=text, description=text)
        command.set_defaults(function=function)
        return command

    add("list", list_runs, [common], "prints the runs: number of the sample, name, whether done, command line")
    add("run", run_all, [common, jobs], "runs what is not done yet; may be stopped and started again")
    return parser


def main():
    arguments = parser_of().parse_args()
    return arguments.function(arguments)


if __name__ == "__main__":
    sys.exit(main())
