"""tools/fault_study: runs the parametric study of fault propagation, measures it and reports on it."""

import argparse
import fnmatch
import shlex
import signal
import sys
from pathlib import Path

from . import plan, reference, report, results
from .scheduler import Scheduler, Task

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
    signal.signal(signal.SIGPIPE, signal.SIG_DFL)  # `list | head` is no error
    for run in chosen_runs(arguments):
        done = "done" if results.is_done(run, arguments.out) else "to do"
        command = run.command(arguments.nappe, arguments.out, arguments.scene)
        print(f"# {run.sample} {run.name}: {done}\n{shlex.join(command)}")
    return 0


def run_task(run, arguments):
    """Goes on with an earlier attempt that left a checkpoint. What another one left must not pass for the first frame
    or the summary of this one; its checkpoints may be of other settings, which nappe asks to be told to overwrite."""
    folder = arguments.out / run.name
    first_frame = folder / "frames" / "frame-00000000.hdf"  # is written when the settled sample has been stored
    stale = ()
    if results.can_go_on(run, arguments.out):
        command = run.restart_command(arguments.nappe, arguments.out)
    else:
        command = run.command(arguments.nappe, arguments.out, arguments.scene)
        stale = (first_frame, folder / "summary.json")
        if results.has_checkpoints(run, arguments.out):
            command.append("--overwrite")
    return Task(
        run.name,
        command,
        arguments.out / "logs" / f"{run.name}.log",
        lambda: results.is_done(run, arguments.out),
        stale,
        group=run.sample,
        ready=first_frame,
    )


def measure_task(run, arguments):
    return Task(
        run.name,
        [str(arguments.nappe), "measure", str(arguments.out / run.name)],
        arguments.out / "logs" / f"{run.name}-measure.log",
        lambda: results.is_measured(run, arguments.out),
    )


def run_all(arguments):
    runs = chosen_runs(arguments)
    missing = [run for run in runs if not results.is_done(run, arguments.out)]
    print(f"{len(runs) - len(missing)} of {len(runs)} runs are done", flush=True)
    return work_off([run_task(run, arguments) for run in missing], arguments.jobs)


def measure_all(arguments):
    runs = [run for run in chosen_runs(arguments) if results.is_done(run, arguments.out)]
    missing = [run for run in runs if arguments.again or not results.is_measured(run, arguments.out)]
    print(f"{len(runs) - len(missing)} of {len(runs)} finished runs are measured", flush=True)
    return work_off([measure_task(run, arguments) for run in missing], arguments.jobs)


def work_off(tasks, n_jobs):
    """The exit code."""
    scheduler = Scheduler(tasks, n_jobs)
    failed = scheduler.run()
    if scheduler.stopped:
        print("stopped; the same command again goes on", flush=True)
        return STOPPED_EARLY
    if failed:
        print(f"{len(failed)} failed: {', '.join(failed)}", flush=True)
    return 1 if failed else 0


def write_report(arguments):
    runs = chosen_runs(arguments)
    ready = [run for run in runs if results.is_done(run, arguments.out) and results.is_measured(run, arguments.out)]
    if not ready:
        sys.exit(f"fault_study: no run in {arguments.out} is both done and measured; start with run, then measure")
    found = [results.read(run, arguments.out) for run in ready]
    for path in report.write(found, len(runs), arguments.out, arguments.pictures or arguments.out / "pictures"):
        print(path)
    return 0


def print_table(arguments):
    print(reference.markdown(arguments.folders))
    return 0


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
    measure = add("measure", measure_all, [common, jobs], "nappe measure on the runs that are done and not measured")
    measure.add_argument("--again", action="store_true", help="on those that are measured too")
    reported = add("report", write_report, [common], "tables, fits and pictures of what is done and measured")
    reported.add_argument("--pictures", type=Path, metavar="PATH", help="their folder (pictures/ of --out)")
    table = add("table", print_table, [], "figures of measured runs of the fault scene side by side, as Markdown")
    table.add_argument("folders", nargs="+", type=Path, metavar="DIR")
    return parser


def main():
    arguments = parser_of().parse_args()
    return arguments.function(arguments)


if __name__ == "__main__":
    sys.exit(main())
