"""tools/torture: runs that are killed, and what becomes of them."""

import argparse
import collections
import getpass
import json
import os
import pathlib
import random
import shutil
import signal
import subprocess
import sys
import tempfile
import time

from processes import alive, children, ranks_of
from same_files import contents

MOST = 120  # s until a killed job must be gone


class Failure(Exception):
    pass


class Campaign:
    def __init__(self, options):
        self.options = options
        self.chance = random.Random(options.seed)
        self.work = pathlib.Path(options.work or tempfile.mkdtemp(prefix="nappe-torture-"))
        self.work.mkdir(parents=True, exist_ok=True)
        self.samples = self.work / "samples"
        self.family = []  # processes of the job in hand
        self.kills = collections.Counter()
        self.codes = collections.Counter()
        self.restarts = collections.Counter()
        self.runs = self.anew = self.in_files = 0


    def start(self, what, ranks):
        name, *rest = what
        line = [self.options.root / "tools/mpirun", "-n", str(ranks), self.options.nappe, name, *map(str, rest)]
        line += ["--samples", self.samples]
        log = open(self.work / "log.txt", "ab")
        return subprocess.Popen(
            line, stdin=subprocess.DEVNULL, stdout=log, stderr=log, env=dict(os.environ, NAPPE_YIELD="1"),
            start_new_session=True,
        )  # fmt: skip

    def scene(self):
        keys = [part for text in self.options.set for part in ("--set", text)]
        return [self.options.scene, *keys]

    def whole(self):
        out = self.work / "whole"
        shutil.rmtree(out, ignore_errors=True)
        begun = time.monotonic()
        code = self.start(["run", *self.scene(), "--out", out], 2).wait()
        if code != 0:
            raise Failure(f"the undisturbed run ended with code {code}; {self.work}/log.txt has its words")
        self.seconds = time.monotonic() - begun
        return out

    def summary(self, out):
        return json.loads((out / "summary.json").read_text())

    def compare(self, whole, out):
        """What is left must be what the undisturbed run left."""
        if self.summary(out)["state_hash"] != self.summary(whole)["state_hash"]:
            raise Failure(f"{out}: state hash {self.summary(out)['state_hash']}")
        names = lambda folder: sorted(  # noqa: E731
            str(p.relative_to(folder)) for p in folder.rglob("*") if p.is_file() and "checkpoints" not in p.parts
        )
        if names(out) != names(whole):
            raise Failure(f"{out}: other files than {whole}: {set(names(out)) ^ set(names(whole))}")
        for name in names(whole):
            if name.endswith(".hdf"):
                same = contents(out / name) == contents(whole / name)
            else:
                same = name == "summary.json" or (out / name).read_bytes() == (whole / name).read_bytes()
            if not same:
                raise Failure(f"{out / name} differs from {whole / name}")

    def is_up(self, process, out):
        """Whether rank 0 holds the folder: MPI has started on all ranks. Before that it is Open MPI's start-up that is hit,
        which can be left waiting for a rank that is gone (docs/reliability.md)."""
        try:
            holder = int((out / ".lock").read_text().split()[1])
        except (OSError, IndexError, ValueError):
            return False
        return holder in ranks_of(process.pid, self.options.nappe)

    def strike(self, process, out):
        """One blow at a random moment; what it was. None: the job was over before."""
        kind = self.chance.choice(("rank -9", "rank -9", "all -9", "mpirun -9", "rank USR1", "mpirun USR1", "mpirun USR2",
                                   "rank TERM", "mpirun TERM", "mpirun INT"))  # fmt: skip
        while process.poll() is None and not self.is_up(process, out):
            time.sleep(0.005)
        moment = time.monotonic() + self.chance.uniform(0, 1) * self.options.span
        in_files = self.chance.random() < 0.3  # wait for a file that is half-written
        while process.poll() is None:
            now = time.monotonic()
            if now > moment and (not in_files or now > moment + 2 or any(out.glob("*/*.part-*"))):
                break
            time.sleep(0.001)
        who, how = kind.split()
        number = {"-9": signal.SIGKILL}.get(how) or getattr(signal, "SIG" + how)
        ranks = ranks_of(process.pid, self.options.nappe)
        if process.poll() is not None or not ranks:
            return None
        self.in_files += any(out.glob("*/*.part-*"))
        self.family = children(process.pid)  # before they lose their parent
        victims = {"rank": [self.chance.choice(ranks)], "all": ranks, "mpirun": [process.pid]}[who]
        for pid in victims:
            try:
                os.kill(pid, number)
            except ProcessLookupError:
                pass
        return kind

    def end(self, process, most=MOST):
        """The job must be gone soon, by itself."""
        try:
            code = process.wait(most)
        except subprocess.TimeoutExpired:
            os.killpg(process.pid, signal.SIGKILL)
            raise Failure(f"a job hangs: process {process.pid}") from None
        deadline = time.monotonic() + MOST
        while alive(self.family):
            if time.monotonic() > deadline:
                raise Failure(f"processes that outlive their job: {alive(self.family)}")
            time.sleep(0.02)
        for path in pathlib.Path("/dev/shm").glob("vader_segment.*"):  # what killed ranks leave
            try:
                if path.owner() == self.user and path.stat().st_mtime > self.begun and not self.in_use(path):
                    path.unlink()
            except OSError:
                pass
        return code

    def in_use(self, path):
        return subprocess.run(["fuser", "-s", path], capture_output=True).returncode == 0

    def go(self):
        self.user = getpass.getuser()
        self.begun = time.time()
        whole = self.whole()
        print(f"undisturbed: {self.seconds:.1f} s, state hash {self.summary(whole)['state_hash']}", flush=True)
        while sum(self.kills.values()) < self.options.kills:
            self.one_run(whole)
        self.report()

    def one_run(self, whole):
        """From the start to the end, with as many blows as it takes."""
        out = self.work / "out"
        shutil.rmtree(out, ignore_errors=True)
        if self.chance.random() < 0.2:  # through its preparation, too
            shutil.rmtree(self.samples, ignore_errors=True)
        self.runs += 1
        blows = 0
        while True:
            ranks = self.chance.randint(1, 5)
            undisturbed = blows >= self.options.blows or sum(self.kills.values()) >= self.options.kills
            every = "50" if undisturbed else self.chance.choice(("1", "3", "10", "50", "1s"))
            if any((out / "checkpoints").glob("*.json")):
                what = ["restart", out, "--checkpoint-every", every]
                self.restarts[ranks] += 1
            else:
                what = ["run", *self.scene(), "--out", out, "--checkpoint-every", every]
                self.anew += blows > 0
            process = self.start(what, ranks)
            kind = None if undisturbed else self.strike(process, out)
            code = self.end(process, MOST if kind else MOST + 100 * self.seconds)
            if kind is None:
                if code != 0:
                    raise Failure(f"{' '.join(map(str, what))} on {ranks} ranks ended with code {code}")
                break
            blows += 1
            self.kills[kind] += 1
            self.codes[kind, code] += 1
            if code in (2, 4) or code < 0 and "mpirun" not in kind:
                raise Failure(f"after {kind}: code {code}")
        self.compare(whole, out)
        print(f"run {self.runs}: {blows} kills ({sum(self.kills.values())} in all), the same as undisturbed", flush=True)

    def report(self):
        print(f"\n{sum(self.kills.values())} kills in {self.runs} runs, {self.in_files} of them while a file was half-written; "
              f"{sum(self.restarts.values())} restarts on {dict(sorted(self.restarts.items()))} ranks, {self.anew} anew "
              "where there was no checkpoint yet; every run ended as the undisturbed one")  # fmt: skip
        for (kind, code), n in sorted(self.codes.items()):
            print(f"  {kind:12} exit code {code:4}: {n}")


def main():
    parser = argparse.ArgumentParser(prog="tools/torture", description=__doc__)
    parser.add_argument("--root", type=pathlib.Path, help=argparse.SUPPRESS)
    parser.add_argument("--nappe", type=os.path.abspath, help="the program [built in build/release]")
    parser.add_argument("--kills", type=int, default=200, help="how many [200]")
    parser.add_argument("--blows", type=int, default=12, help="in one run at most [12]")
    parser.add_argument("--span", type=float, default=1.5, help="s from a start to a kill at most [1.5]")
    parser.add_argument("--seed", type=int, default=1, help="of the moments and the victims [1]")
    parser.add_argument("--scene", help="scene file [tests/support/scenes/small_fold.toml, loaded for longer]")
    parser.add_argument("--set", action="append", default=[], metavar="KEY=VALUE", help="as of nappe run")
    parser.add_argument("--work", help="folder for all runs; kept [one that is removed]")
    options = parser.parse_args()
    if options.scene is None:
        options.scene = options.root / "tests/support/scenes/small_fold.toml"
        options.set = ["stages.push.duration=20", "walls.piston.motion.velocity=[0.15,0]",
                       "output.measures.energy=true", *options.set]  # fmt: skip
    campaign = Campaign(options)
    try:
        campaign.go()
    except Failure as failure:
        print(f"torture: {failure}\ntorture: everything is left in {campaign.work}", file=sys.stderr)
        return 1
    if not options.work:
        shutil.rmtree(campaign.work)
    return 0


if __name__ == "__main__":
    sys.exit(main())
