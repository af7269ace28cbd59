"""What tests of faults share: a scene that runs for some seconds, how to wait for a moment of it, and what must hold after
it has been taken up again."""

import json
import os
import pathlib
import shutil
import sys
import time

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parent.parent / "support"))
from nappe_driver import SCENES, Run, call, paths, sets, start  # noqa: E402
from same_files import SameFiles  # noqa: E402

FOLD = SCENES / "small_fold.toml"
DONE, OTHER, BAD_INPUT, STOPPED, NUMERICAL = 0, 1, 2, 3, 4
# Four times the scene's own loading, as far.
LONG = sets(stages__push__duration=6, walls__piston__motion__velocity="[0.25, 0]")
MOST = 60  # s that a job may take to end after one of its ranks died; it takes two or three on an idle machine


class FaultTest(SameFiles):
    @classmethod
    def setUpClass(cls):
        super().setUpClass()
        cls.samples = cls.class_folder / "samples"
        result = call(["run", FOLD, *LONG, "--out", cls.class_folder / "whole", "--samples", cls.samples], 2)
        assert result.code == DONE, str(result)
        cls.whole = Run(cls.class_folder / "whole", result)

    def setUp(self):
        super().setUp()
        self.out = self.folder / "out"

    def start(self, *arguments, ranks=2, out=None):
        """On a slow network (slow_network.cpp): a second at least, however fast the machine, for a moment to come in."""
        return start(
            ["run", FOLD, *LONG, "--out", out or self.out, "--samples", self.samples, *arguments], ranks, self.folder,
            LD_PRELOAD=f"{os.environ['NAPPE_SLOW_NETWORK']} {os.environ.get('LD_PRELOAD', '')}",
        )  # fmt: skip

    def run_it(self, *arguments, ranks=2, out=None, code=DONE):
        result = call(
            ["run", FOLD, *LONG, "--out", out or self.out, "--samples", self.samples, *arguments], ranks, self.folder
        )
        self.assertEqual(result.code, code, str(result))
        return result

    def restart(self, *arguments, ranks=2, code=DONE):
        result = call(["restart", self.out, "--samples", self.samples, *arguments], ranks, self.folder)
        self.assertEqual(result.code, code, str(result))
        return Run(self.out, result)

    def wait(self, process, when):
        deadline = time.monotonic() + 120
        while process.poll() is None and time.monotonic() < deadline:
            if when():
                return
            time.sleep(0.001)
        self.fail(f"the moment did not come: {process.communicate()}")

    def wait_for(self, when):
        deadline = time.monotonic() + MOST
        while not when():
            self.assertLess(time.monotonic(), deadline, "it takes too long")
            time.sleep(0.02)

    def rows(self):
        file = self.out / "series/front.csv"
        return len(file.read_text().splitlines()) - 1 if file.exists() else 0

    def checkpoints(self):
        return sorted((self.out / "checkpoints").glob("*.json"))

    def last_step(self):
        """That of the newest checkpoint."""
        return json.loads(self.checkpoints()[-1].read_text())["notes"]["step"]

    def assert_goes_on(self, *arguments, ranks=3):
        """Restart, to what the whole run left."""
        run = self.restart(*arguments, ranks=ranks)
        self.assert_same(self.whole, run)
        self.assertEqual([name for name in run.files() if ".part-" in name], [])
        return run

    def contents(self):
        return {p: p.read_bytes() for p in self.out.rglob("*") if p.is_file() and not p.is_symlink()}

    def fresh(self):
        shutil.rmtree(self.out, ignore_errors=True)


__all__ = ["BAD_INPUT", "DONE", "FOLD", "FaultTest", "LONG", "MOST", "NUMERICAL", "OTHER", "Run", "STOPPED", "call",
           "paths", "sets", "start"]  # fmt: skip
