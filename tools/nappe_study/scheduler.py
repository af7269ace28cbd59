"""Runs programs, several at a time, each with one rank."""

import dataclasses
import signal
import subprocess
import time
from collections.abc import Callable
from pathlib import Path

LOOK_EVERY = 0.2  # s between two looks at the programs under way
STOP_SIGNALS = signal.SIGTERM, signal.SIGUSR1, signal.SIGINT


@dataclasses.dataclass
class Task:
    """A program to run. Its output goes to `log`; `stale`, files of an earlier attempt, are removed before it starts.

    Tasks of one `group` share something that the first of them makes; it is there once the file `ready` is.
    """

    name: str
    command: list
    log: Path
    is_done: Callable  # () -> whether the results are there
    stale: tuple = ()
    group: int | None = None
    ready: Path | None = None


class _Job:
    """A task under way."""

    def __init__(self, task):
        self.task = task
        for file in task.stale:
            file.unlink(missing_ok=True)
        task.log.parent.mkdir(parents=True, exist_ok=True)
        self.start = time.monotonic()
        with task.log.open("wb") as file:
            self.process = subprocess.Popen(
                task.command, stdout=file, stderr=subprocess.STDOUT, stdin=subprocess.DEVNULL
            )

    @property
    def ended(self):
        return self.process.poll() is not None

    @property
    def blocks(self):
        """The group whose other tasks have to wait, or None."""
        return None if self.task.ready is None or self.task.ready.exists() else self.task.group

    def seconds(self):
        return time.monotonic() - self.start


class Scheduler:
    """Keeps `n_jobs` tasks going until all are done, in their order but for those that wait for others of their group.

    A signal (TERM, USR1, INT) is passed on as TERM, upon which nappe stops after the step in hand; nothing new begins.
    """

    def __init__(self, tasks, n_jobs):
        self._waiting = list(tasks)
        self._n_jobs = n_jobs
        self._under_way = []
        self._failed = []
        self.stopped = False

    def run(self):
        """Names of the tasks that failed. Says what begins and ends."""
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
            blocked = {job.blocks for job in self._under_way} - {None}
            task = next((task for task in self._waiting if task.group not in blocked), None)
            if task is None:
                return
            self._waiting.remove(task)
            self._under_way.append(_Job(task))
            print(f"{task.name}: begun", flush=True)

    def _end(self):
        for job in [job for job in self._under_way if job.ended]:
            self._under_way.remove(job)
            task, code = job.task, job.process.returncode
            if code == 0 and task.is_done():
                print(f"{task.name}: done in {job.seconds():.0f} s, {len(self._waiting)} to begin", flush=True)
            else:
                self._failed.append(task.name)
                how = f"exit code {code}" if code else "exit code 0, but its results are not complete"
                print(f"{task.name}: ended with {how}; see {task.log}", flush=True)
