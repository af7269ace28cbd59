"""Runs what is not done yet, several at a time, each with one rank."""

import json
import signal
import subprocess
import time

LOOK_EVERY = 0.2  # s between two looks at the runs under way
STOP_SIGNALS = signal.SIGTERM, signal.SIGUSR1, signal.SIGINT


def summary_of(run, out):
    """The run's summary, or {} while there is none."""
    try:
        return json.loads((out / run.name / "summary.json").read_text())
    except (OSError, json.JSONDecodeError):
        return {}


def is_done(run, out):
    return run.is_done(summary_of(run, out))


class _Job:
    """A run under way; its output goes to logs/NAME.log."""

    def __init__(self, run, command, out):
        self.run = run
        self.first_frame = out / run.name / "frames" / "frame-00000000.hdf"
        self.log = out / "logs" / f"{run.name}.log"
        self.log.parent.mkdir(parents=True, exist_ok=True)
        # What an earlier run left must not pass for the frame or the summary of this one.
        for stale in (self.first_frame, out / run.name / "summary.json"):
            stale.unlink(missing_ok=True)
        self.start = time.monotonic()
        with self.log.open("wb") as file:
            self.process = subprocess.Popen(command, stdout=file, stderr=subprocess.STDOUT, stdin=subprocess.DEVNULL)

    def prepares(self):
        """Whether it may still be settling its sample: the first frame is written after the sample is stored."""
        return self.process.poll() is None and not self.first_frame.exists()

    def seconds(self):
        return time.monotonic() - self.start


class Scheduler:
    """Keeps `jobs` runs going until all are done.

    Of the runs that share a sample one goes ahead until the sample is stored; meanwhile the next sample is begun. A
    signal (TERM, USR1, INT) is passed on to the runs, which then stop after the step in hand; nothing new begins.
    """

    def __init__(self, runs, jobs, out, command_of):
        self._waiting = list(runs)
        self._n_jobs = jobs
        self._out = out
        self._command_of = command_of
        self._under_way = []
        self._failed = []
        self.stopped = False

    def run(self):
        """Names of the runs that failed. Says what begins and ends."""
        handlers = {number: signal.signal(number, self._stop) for number in STOP_SIGNALS}
        try:
            while self._under_way or (self._waiting and not self.stopped):
                self._begin()
                time.sleep(LOOK_EVERY)
                self._end()
        finally:
            for number, handler in handlers.items():
                signal.signal(number, handler)
        return self._failed

    def _stop(self, number, frame):
        self.stopped = True
        for job in self._under_way:
            job.process.send_signal(signal.SIGTERM)

    def _begin(self):
        while len(self._under_way) < self._n_jobs and not self.stopped:
            preparing = {job.run.sample for job in self._under_way if job.prepares()}
            ready = next((run for run in self._waiting if run.sample not in preparing), None)
            if ready is None:
                return
            self._waiting.remove(ready)
            self._under_way.append(_Job(ready, self._command_of(ready), self._out))
            print(f"{ready.name}: begun", flush=True)

    def _end(self):
        for job in [job for job in self._under_way if job.process.poll() is not None]:
            self._under_way.remove(job)
            name, code = job.run.name, job.process.returncode
            if code == 0 and is_done(job.run, self._out):
                print(f"{name}: done in {job.seconds():.0f} s, {len(self._waiting)} to begin", flush=True)
            else:
                self._failed.append(name)
                how = f"exit code {code}" if code else "exit code 0, but its summary is not that of this run"
                print(f"{name}: ended with {how}; see {job.log}", flush=True)
