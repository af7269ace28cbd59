"""The batch scripts under a real Slurm (local_slurm): jobs/fold-small.sbatch on two nodes, stopped by signals, killed,
left by a node, ends in the state hash and the series of a job that nobody disturbed.

Usage: slurm_test.py --nappe PATH [--long] [arguments of unittest]. Exit code 77: Slurm is not installed here, nothing was
tried. --long: real time limits too, some minutes."""

import argparse
import json
import math
import os
import pathlib
import re
import shutil
import signal
import subprocess
import sys
import tempfile
import time
import unittest

ROOT = pathlib.Path(__file__).resolve().parents[2]
LOCAL_SLURM = pathlib.Path(__file__).resolve().parent / "local_slurm"
SKIPPED = 77
LIMIT = 240  # s for anything to happen; on an idle machine all takes seconds
STEPS = 400  # of loading: 4 s on two cores; signals must find it under way
ENDS = ("COMPLETED", "FAILED", "CANCELLED", "TIMEOUT", "NODE_FAIL")

told = argparse.Namespace(nappe=None, long=False)
cluster = None


class Cluster:
    """Daemons of our own, in a folder of their own; gone with this process, however it ends."""

    def __init__(self, owner):
        # Short: the name of a socket in it must not exceed 107 bytes.
        self.folder = pathlib.Path(tempfile.mkdtemp(prefix="nappe-slurm-", dir="/tmp"))
        started = subprocess.run(
            [LOCAL_SLURM, "start", self.folder, "--owner", str(owner)],
            stdout=subprocess.PIPE,
            text=True,
            stdin=subprocess.DEVNULL,
        )
        self.code = started.returncode
        exports = re.findall(r"(\w+)=(\S+)", started.stdout)
        self.environment = dict(os.environ, **dict(exports))

    def call(self, *command, check=True):
        return subprocess.run(
            list(map(str, command)),
            env=self.environment,
            cwd=ROOT,
            stdin=subprocess.DEVNULL,
            stdout=subprocess.PIPE,
            text=True,
            check=check,
            timeout=LIMIT,
        ).stdout.strip()

    def restart_node(self, name):
        subprocess.run([LOCAL_SLURM, "node", self.folder, name], check=True)

    def stop(self):
        subprocess.run([LOCAL_SLURM, "stop", self.folder], check=True)
        shutil.rmtree(self.folder, ignore_errors=True)


class Job:
    """A submitted jobs/fold-small.sbatch."""

    def __init__(self, out, *arguments, options=(), **variables):
        self.out = out
        self.log = out.with_suffix(".log")
        environment = {
            **cluster.environment,
            "NAPPE": str(told.nappe),
            "OUT": str(out),
            "MPIRUN": "mpirun --bind-to none",  # two nodes share this machine's cores
            **variables,
        }
        # A rank for each node: four would fight for two cores.
        command = ["sbatch", "--parsable", "--ntasks-per-node=1", f"--output={self.log}", *options]
        self.id = subprocess.run(
            [*command, "jobs/fold-small.sbatch", *map(str, arguments)],
            env=environment,
            cwd=ROOT,
            stdout=subprocess.PIPE,
            text=True,
            check=True,
        ).stdout.strip()

    def show(self):
        words = cluster.call("scontrol", "show", "job", self.id).split()
        return dict(word.split("=", 1) for word in words if "=" in word)

    def printed(self):
        return self.log.read_text(errors="replace") if self.log.exists() else "nothing"

    def until(self, what, condition, limit=LIMIT):
        """Fails as soon as the job has ended without it."""
        deadline = time.monotonic() + limit
        while not condition():
            ended = self.show()["JobState"] in ENDS
            if condition():
                return
            if ended or time.monotonic() > deadline:
                why = "before the job ended" if ended else f"in {limit} s"
                raise AssertionError(f"{what} did not come about {why}: {self.show()}\n{self.printed()}")
            time.sleep(0.1)

    def step(self):
        """Of the last row of its series; 0 before there is one."""
        try:
            row = (self.out / "series/solver.csv").read_text().splitlines()[-1]
            return int(row.split(",")[0])
        except (OSError, ValueError, IndexError):
            return 0

    def until_further(self):
        """An eighth of the way further than now: something to lose, and the half of the way left after four times."""
        wanted = self.step() + STEPS // 8
        self.until(f"step {wanted}", lambda: self.step() >= wanted)

    def until_started_again(self, times):
        """Slurm waits before it starts a requeued job again: ten seconds here, two minutes on most clusters. It is told
        to begin at once; in two seconds, so that the new credential is younger than the one it has revoked."""
        self.until("a requeue", lambda: int(self.show()["Restarts"]) >= times)
        self.until("the end of what was requeued", lambda: self.show()["JobState"] != "COMPLETING")
        if self.show()["JobState"] == "PENDING":
            cluster.call("scontrol", "update", f"JobId={self.id}", "StartTime=now+2")
        self.until("another start", lambda: self.show()["JobState"] == "RUNNING")

    def until_ended(self, limit=LIMIT):
        self.until("an end", lambda: self.show()["JobState"] in ENDS, limit)
        return self.show()

    def ranks(self):
        """Its processes that compute, and the node of each."""
        found = {}
        for folder in pathlib.Path("/proc").glob("[0-9]*"):
            try:
                words = (folder / "cmdline").read_bytes().split(b"\0")
                variables = dict(v.partition(b"=")[::2] for v in (folder / "environ").read_bytes().split(b"\0"))
                if str(self.out).encode() in words and b"OMPI_COMM_WORLD_RANK" in variables:
                    found[int(folder.name)] = variables[b"SLURMD_NODENAME"].decode()
            except OSError:
                pass  # it has ended meanwhile
        return found


def command_of(process):
    try:
        return pathlib.Path(f"/proc/{process}/cmdline").read_bytes()
    except OSError:
        return b""  # it has ended meanwhile


def parent_of(process):
    return int(re.search(r"^PPid:\s+(\d+)", pathlib.Path(f"/proc/{process}/status").read_text(), re.MULTILINE)[1])


class Slurm(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.folder = pathlib.Path(tempfile.mkdtemp(prefix="nappe-test-"))
        cls.addClassCleanup(shutil.rmtree, cls.folder, ignore_errors=True)
        cls.whole = cls.folder / "undisturbed"
        ended = Job(cls.whole, "--steps", STEPS).until_ended()
        if ended["ExitCode"] != "0:0":
            raise AssertionError((cls.folder / "undisturbed.log").read_text())

    def assert_same(self, job, restarts, goes_on=None, whole=None):
        """That it has ended well after so many requeues, as the undisturbed one did, and never began anew."""
        whole = whole or self.whole
        goes_on = restarts if goes_on is None else goes_on
        ended = job.until_ended()
        self.assertEqual((ended["JobState"], ended["ExitCode"]), ("COMPLETED", "0:0"), job.printed())
        self.assertEqual(int(ended["Restarts"]), restarts, job.printed())
        self.assertEqual(job.printed().count("goes on with"), goes_on, job.printed())
        summary, wanted = (json.loads((out / "summary.json").read_text()) for out in (job.out, whole))
        self.assertFalse(summary["stopped_early"])
        self.assertEqual((summary["steps"], summary["state_hash"]), (wanted["steps"], wanted["state_hash"]))
        for file in sorted((whole / "series").glob("*.csv")):
            self.assertEqual((job.out / "series" / file.name).read_bytes(), file.read_bytes(), file.name)
        frames = [sorted(path.name for path in (out / "frames").iterdir()) for out in (job.out, whole)]
        self.assertEqual(frames[0], frames[1])

    def test_signals(self):
        """USR1 twice: it goes on by itself. Then USR2: that ends it, and another job for the same folder goes on."""
        job = Job(self.folder / "signalled", "--steps", STEPS)
        for times in (1, 2):
            job.until_further()
            cluster.call("scancel", "-b", "-s", "USR1", job.id)
            job.until_started_again(times)
        job.until_further()
        cluster.call("scancel", "-b", "-s", "USR2", job.id)
        ended = job.until_ended()
        self.assertEqual((ended["JobState"], ended["ExitCode"]), ("FAILED", "3:0"), job.printed())
        self.assertEqual(job.printed().count("goes on with"), 2)

        job.log.unlink()
        second = Job(self.folder / "signalled", "--steps", STEPS)
        self.assert_same(second, 0, goes_on=1)

    def test_kills(self):
        """A rank is killed; later a whole node is gone. Both times it goes on from a periodic checkpoint."""
        job = Job(self.folder / "killed", "--steps", STEPS, "--checkpoint-every", STEPS // 16)
        job.until_further()
        os.kill(next(iter(job.ranks())), signal.SIGKILL)
        job.until_started_again(1)
        self.assertIn("exit code 137", job.printed())

        job.until_further()
        on_node = [process for process, node in job.ranks().items() if node == "near"]
        self.assertEqual(len(on_node), 1)
        orted = parent_of(on_node[0])
        for process in (int((cluster.folder / "near.pid").read_text()), parent_of(orted), orted, *on_node):
            os.kill(process, signal.SIGKILL)
        # Slurm would find out by itself, in minutes.
        cluster.call("scontrol", "update", "NodeName=near", "State=DOWN", "Reason=killed")
        cluster.restart_node("near")
        cluster.call("scontrol", "update", "NodeName=near", "State=RESUME", check=False)  # if it is not back already
        job.until_started_again(2)
        self.assertIn("DUE TO NODE FAILURE", job.printed())
        self.assert_same(job, 2)

    @unittest.skipUnless("--long" in sys.argv, "takes minutes: --long")
    def test_time_limits(self):
        """Jobs of one minute, again and again: one that hears of it by USR1, one that looks at its clock alone."""
        summary = json.loads((self.whole / "summary.json").read_text())
        all_steps, wanted = 5000, 120  # of the scene; s of loading
        sweeps = math.ceil(100 * wanted * STEPS / (all_steps * summary["seconds_loading"]))
        slow = ["--set", f"stages.push.solver.sweeps={max(100, sweeps)}"]
        whole = Job(self.folder / "long-undisturbed", *slow)
        self.assertEqual(whole.until_ended(30 * LIMIT)["ExitCode"], "0:0", whole.printed())
        for name, options, arguments in (
            ("by-signal", ["--signal=B:USR1@5"], ["--wall-time", "10:00:00"]),
            ("by-clock", ["--signal=B:URG@1"], []),  # URG: bash does not mind
        ):
            with self.subTest(name):
                job = Job(self.folder / name, *slow, *arguments, options=["--time=1", *options])
                restarts = int(job.until_ended(30 * LIMIT)["Restarts"])
                print(f"{name}: {restarts} requeues")
                self.assertGreaterEqual(restarts, 2, job.printed())
                self.assert_same(job, restarts, whole=whole.out)


def processes_of(folder):
    """Those that carry its name: daemons, slurmstepd, what jobs have started."""
    found = []
    for variables in pathlib.Path("/proc").glob("[0-9]*/environ"):
        try:
            if str(folder).encode() in variables.read_bytes():
                found.append(variables.parent.name)
        except OSError:
            pass
    return found


class LocalSlurm(unittest.TestCase):
    """It leaves nothing behind."""

    def assert_gone(self, folder):
        deadline = time.monotonic() + 60
        while folder.exists() or processes_of(folder):
            self.assertLess(time.monotonic(), deadline, f"{folder} is still there, or {processes_of(folder)}")
            time.sleep(0.2)

    def test_it_ends_with_its_owner(self):
        owner = subprocess.Popen(["sleep", "600"])
        try:
            mine = Cluster(owner.pid)
            self.assertEqual(mine.code, 0)
            job = mine.call("sbatch", "--parsable", "--nodes=2", "--output=/dev/null", "--wrap", "srun sleep 600")
            deadline = time.monotonic() + LIMIT
            while len([p for p in processes_of(mine.folder) if (b"sleep\x00600" in command_of(p))]) < 2:
                self.assertLess(time.monotonic(), deadline, f"job {job} did not begin")
                time.sleep(0.1)
        finally:
            owner.kill()
            owner.wait()
        self.assert_gone(mine.folder)

    def test_a_start_that_fails(self):
        with tempfile.TemporaryDirectory() as other:
            daemon = pathlib.Path(other) / "slurmd"
            daemon.write_text("#!/bin/sh\nexit 1\n")
            daemon.chmod(0o755)
            folder = pathlib.Path(tempfile.mkdtemp(prefix="nappe-slurm-", dir="/tmp"))
            environment = dict(os.environ, PATH=f"{other}:{os.environ['PATH']}")
            started = subprocess.run(
                [LOCAL_SLURM, "start", folder], env=environment, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True
            )
        self.assertEqual(started.returncode, 1, started.stderr)
        self.assertIn("could not start", started.stderr)
        self.assertEqual(started.stdout, "")
        self.assert_gone(folder)


def main():
    global cluster
    parser = argparse.ArgumentParser()
    parser.add_argument("--nappe", type=pathlib.Path, required=True)
    parser.add_argument("--long", action="store_true")
    _, rest = parser.parse_known_args(namespace=told)
    told.nappe = told.nappe.resolve()
    cluster = Cluster(os.getpid())
    if cluster.code != 0:
        shutil.rmtree(cluster.folder, ignore_errors=True)
    if cluster.code == SKIPPED:
        print("SKIPPED: the batch scripts were NOT tried under Slurm, which is not installed here: tools/setup slurm")
    if cluster.code != 0:
        sys.exit(cluster.code)
    try:
        done = unittest.main(argv=[sys.argv[0], *rest], verbosity=2, exit=False)
    finally:
        cluster.stop()
    sys.exit(not done.result.wasSuccessful())


if __name__ == "__main__":
    main()
