"""What machines do to runs. Each fault is really caused; then the job must have ended by itself, with a code other than 0,
within seconds and with words; and what it had must go on to what an undisturbed run leaves, with nothing good
overwritten."""

import os
import random
import re
import shutil
import signal
import subprocess
import time

from processes import alive, children, ranks_of
from run_kit import BAD_INPUT, DONE, FOLD, LONG, MOST, NUMERICAL, OTHER, FaultTest, call, paths, sets, start

from nappe_driver import Run, finish, main

import h5py


class Killed(FaultTest):
    """kill -9, which no program hears."""

    def kill(self, process, victims):
        family = children(process.pid)
        for pid in victims(process):
            os.kill(pid, signal.SIGKILL)
        result = finish(process, MOST)
        self.assertNotEqual(result.code, DONE)
        self.wait_for(lambda: not alive(family))

    def test_of_one_rank_or_all_at_random_moments(self):
        chance = random.Random(9)
        one = lambda process: [chance.choice(ranks_of(process.pid, paths.nappe))]  # noqa: E731
        every = lambda process: ranks_of(process.pid, paths.nappe)  # noqa: E731
        launcher = lambda process: [process.pid]  # noqa: E731
        for k, victims in enumerate((one, every, launcher, one)):
            with self.subTest(kill=k):
                self.fresh()
                process = self.start("--checkpoint-every", "3", ranks=2 + k % 2)
                self.wait(process, self.checkpoints)
                time.sleep(chance.uniform(0, 1))
                self.kill(process, victims)
                self.assert_goes_on(ranks=1 + k % 3)

    def half_written(self, folder, *arguments):
        process = self.start(*arguments)
        self.wait(process, lambda: self.checkpoints() and any((self.out / folder).glob("*.part-*")))
        self.kill(process, lambda process: ranks_of(process.pid, paths.nappe))

    def test_while_a_checkpoint_is_written(self):
        for _ in range(3):  # until a kill has come in the middle of it
            self.fresh()
            self.half_written("checkpoints", "--checkpoint-every", "1")
            if any((self.out / "checkpoints").glob("*.part-*")):
                break
        self.assert_goes_on()

    def test_while_a_frame_is_written(self):
        frames = ["--set", "output.frames.every=2", "--checkpoint-every", "10"]
        whole = self.run_it(*frames, out=self.folder / "whole")
        for _ in range(3):
            self.fresh()
            self.half_written("frames", *frames)
            if any((self.out / "frames").glob("*.part-*")):
                break
        run = self.restart()
        self.assert_same(Run(self.folder / "whole", whole), run)


def with_mounts(test):
    """Skips where this machine lets nobody mount a file system of its own."""

    def wrapped(self):
        disk = self.folder / "disk"
        disk.mkdir()
        made = subprocess.run(["mount", "-t", "tmpfs", "-o", "size=6m", "tmpfs", disk], capture_output=True)
        if made.returncode != 0:
            self.skipTest("no file system can be mounted here")
        try:
            test(self, disk)
        finally:
            subprocess.run(["umount", "--lazy", disk], check=True)

    return wrapped


class Disks(FaultTest):
    """A disk of 6 MB; a checkpoint of this scene has 60 kB, a frame 70 kB."""

    def ends_with_words(self, process, *words):
        result = finish(process, MOST)
        self.assertEqual(result.code, OTHER, str(result))
        self.assertEqual(len(result.errors), 1, result.err)
        for word in words:
            self.assertIn(word, result.errors[0])
        self.assertNotIn("HDF5-DIAG", result.err)
        return result

    @with_mounts
    def test_full_while_frames_are_written(self, disk):
        self.out = disk / "out"
        process = self.start("--set", "output.frames.every=1", "--checkpoint-every", "5")
        self.ends_with_words(process, "frame", "free")
        self.assertTrue(self.checkpoints(), "the disk filled up too early: the case is none")
        for frame in sorted((self.out / "frames").glob("*"))[20:]:
            self.assertNotIn(".part-", frame.name)
        subprocess.run(["mount", "-o", "remount,size=60m", disk], check=True)
        whole = self.run_it("--set", "output.frames.every=1", out=self.folder / "whole")
        self.assert_same(Run(self.folder / "whole", whole), self.restart())

    @with_mounts
    def test_full_for_checkpoints_alone(self, disk):
        # The run goes on, each time with a word, and the checkpoint before stands.
        self.out = disk / "out"
        process = self.start("--checkpoint-every", "5", "--set", "output.frames.every=1000")
        self.wait(process, self.checkpoints)
        process.send_signal(signal.SIGSTOP)
        for pid in ranks_of(process.pid, paths.nappe):
            os.kill(pid, signal.SIGSTOP)
        room = os.statvfs(disk).f_bavail * os.statvfs(disk).f_frsize
        subprocess.run(["fallocate", "-l", str(room - 100000), disk / "ballast"], check=True)  # enough for rows
        rows = self.rows()
        for pid in [*ranks_of(process.pid, paths.nappe), process.pid]:
            os.kill(pid, signal.SIGCONT)
        self.wait(process, lambda: self.rows() > rows + 3)
        (disk / "ballast").unlink()
        result = finish(process)
        self.assertEqual(result.code, DONE, str(result))
        self.assertIn("no checkpoint: ", result.err)
        self.assertIn("no room for", result.err)
        self.assertIn("stands", result.err)
        run = Run(self.out, result)
        self.assertEqual(run.hash, self.whole.hash)
        self.assertGreater(run.summary["checkpoints"]["failed"], 0)
        self.assertEqual(len(self.checkpoints()), 2)
        (self.out / "summary.json").unlink()
        self.assertEqual(self.restart().hash, self.whole.hash)

    @with_mounts
    def test_read_only(self, disk):
        self.out = disk / "out"
        process = self.start("--checkpoint-every", "5")
        self.wait(process, self.checkpoints)
        family = children(process.pid)
        os.kill(process.pid, signal.SIGKILL)
        finish(process)
        self.wait_for(lambda: not alive(family))
        self.wait_for(lambda: subprocess.run(["mount", "-o", "remount,ro", disk], capture_output=True).returncode == 0)
        for command in ("run", "restart"):
            before = self.contents()
            what = [FOLD, *LONG, "--out", self.out] if command == "run" else [self.out]
            self.ends_with_words(start([command, *what, "--samples", self.samples], 2), "Read-only", "choose")
            self.assertEqual(self.contents(), before)
        subprocess.run(["mount", "-o", "remount,rw", disk], check=True)
        self.assert_goes_on()


class Files(FaultTest):
    """Files that are not what they were."""

    def setUp(self):
        super().setUp()
        self.run_it("--checkpoint-every", "20", "--steps", "50")
        self.newest = self.checkpoints()[-1]

    def damage(self, path, change):
        data = bytearray(path.read_bytes())
        path.write_bytes(change(data))

    def test_a_damaged_checkpoint_gives_way_to_the_one_before(self):
        def flip(data):
            data[len(data) // 2] ^= 4
            return data

        cases = {
            "cut": (".hdf", lambda data: data[: len(data) // 2], "bytes instead of"),
            "emptied": (".hdf", lambda data: b"", "has 0 bytes instead of"),
            "one bit": (".hdf", flip, "is damaged"),
            "manifest cut": (".json", lambda data: data[: len(data) // 2], "the manifest is damaged"),
            "manifest of one bit": (".json", flip, "the manifest is damaged"),
        }
        saved = {suffix: self.newest.with_suffix(suffix).read_bytes() for suffix in (".hdf", ".json")}
        for name, (suffix, change, said) in cases.items():
            with self.subTest(damage=name):
                for kind, data in saved.items():
                    self.newest.with_suffix(kind).write_bytes(data)
                out = self.folder / f"copy-{name}"
                shutil.copytree(self.out, out)
                self.damage(out / "checkpoints" / self.newest.with_suffix(suffix).name, change)
                result = call(["restart", out, "--samples", self.samples], 2)
                self.assertEqual(result.code, DONE, str(result))
                self.assertIn("not used: ", result.err)
                self.assertIn(said, result.err)
                self.assertIn("step 40,", result.err)
                self.assert_same(self.whole, Run(out, result))

    def test_no_good_one_is_code_2_and_nothing_is_touched(self):
        for path in self.checkpoints():
            self.damage(path.with_suffix(".hdf"), lambda data: data[:-1])
        before = self.contents()
        result = self.restart(code=BAD_INPUT).result
        self.assertEqual(len(result.errors), 1, result.err)
        self.assertIn("must hold a sound checkpoint", result.errors[0])
        self.assertEqual(result.errors[0].count("bytes instead of"), 2)
        self.assertEqual(self.contents(), before)
        shutil.rmtree(self.out / "checkpoints")
        self.assertIn("one that has come to its end with step 50", self.restart(code=BAD_INPUT).result.err)
        (self.out / "summary.json").unlink()
        self.assertIn("found none; begin with nappe run", self.restart(code=BAD_INPUT).result.err)
        self.assertIn("must be the folder of a run", call(["restart", self.folder / "nowhere"]).err)

    def test_one_that_can_not_be_read_now_is_not_gone_behind(self):
        # A link to itself: what rights and failing disks are to a process that may read everything.
        good = self.newest.with_suffix(".hdf").rename(self.folder / "good.hdf")
        self.newest.with_suffix(".hdf").symlink_to(self.newest.with_suffix(".hdf").name)
        before = self.contents()
        result = self.restart(code=BAD_INPUT).result
        self.assertIn("make it readable, or take this checkpoint out", result.errors[0])
        self.assertEqual(self.contents(), before)
        self.newest.with_suffix(".hdf").unlink()
        good.rename(self.newest.with_suffix(".hdf"))
        self.assert_goes_on()

    def test_another_scene(self):
        other = self.folder / "other"
        self.run_it("--set", "sample.seed=8", "--steps", "10", out=other)
        for path in (self.out / "checkpoints").iterdir():
            path.unlink()
        for path in (other / "checkpoints").iterdir():
            shutil.copy(path, self.out / "checkpoints")
        result = self.restart(code=BAD_INPUT).result
        self.assertIn("found another than", result.errors[0])

    def test_a_series_that_lost_rows(self):
        file = self.out / "series/front.csv"
        whole = file.read_bytes()
        file.write_bytes(whole[:40])
        before = self.contents()
        result = self.restart(code=OTHER).result
        self.assertIn("rows are lost", result.errors[0])
        self.assertEqual(self.contents(), before, "the other series are cut, or the summary is gone")
        file.unlink()
        self.assertIn("front.csv", self.restart(code=OTHER).result.errors[0])
        file.write_bytes(whole)
        self.assert_goes_on()

    def test_remains_of_a_run_that_died(self):
        for name in ("frames/frame-00000060.hdf", "frames/frame-00000057.hdf.part-host-1", "summary.json.part-host-1",
                     "checkpoints/checkpoint-000009.hdf.part-host-1", "checkpoints/checkpoint-000009.hdf"):  # fmt: skip
            (self.out / name).write_bytes(b"half a file")
        run = self.assert_goes_on()
        self.assertNotIn("checkpoints/checkpoint-000009.hdf", run.files())

    def test_a_damaged_sample_is_made_again(self):
        samples = self.folder / "samples"
        shutil.copytree(self.samples, samples)
        for path in samples.glob("*.hdf"):
            self.damage(path, lambda data: data[:-7])
        result = call(["run", FOLD, *LONG, "--out", self.folder / "new", "--samples", samples], 2)
        self.assertIn("bytes instead of", result.err)
        self.assertEqual(Run(self.folder / "new", result).hash, self.whole.hash)


class Failures(FaultTest):
    """Steps that can not be taken, or that [watch] stops (parallel.watch has what is found, and where)."""

    def fails(self, key, value):
        result = self.run_it("--set", f"{key}={value}", "--checkpoint-every", "50", code=NUMERICAL)
        self.assertEqual(len(result.errors), 1, result.err)
        self.assertIn("the state before the step that failed is in a checkpoint", result.err)
        self.assertNotIn("summary.json", [path.name for path in self.out.iterdir()])
        return result.errors[0]

    def test_a_grain_outside_bounds_leaves_the_state_before(self):
        # The highest centre rises while the piston pushes.
        def highest(frame):
            with h5py.File(self.whole.out / "frames" / frame) as file:
                return max(file["VTKHDF/Points"][:, 1])

        frames = sorted(path.name for path in (self.whole.out / "frames").iterdir())
        first, last = highest(frames[0]), max(highest(frame) for frame in frames)
        self.assertGreater(last, first + 0.02, "nothing rises: the case is none")
        said = self.fails("watch.bounds", f"{{ min = [-1, -1], max = [50, {(first + last) / 2}] }}")
        step = int(re.search(r"step (\d+) of stage 'push'", said)[1])
        self.assertIn("grain ", said)
        self.assertEqual(self.last_step(), step - 1)
        before = self.checkpoints()
        self.assertIn(f"step {step} of", self.restart(code=NUMERICAL, ranks=3).result.errors[0])
        self.assertEqual(self.last_step(), step - 1)
        self.assertEqual(self.checkpoints(), before, "the same state twice, in place of the one before the trouble")
        run = self.restart("--set", "watch.bounds.do=warn")
        self.assertGreater(run.summary["watch"]["bounds"], 0)
        self.assert_same(self.whole, run, but=["scene.toml"])

    def test_a_step_that_fails_while_a_sample_is_prepared(self):
        # A sample is kept for other runs: what is taken up after a stop must be the one that all would have made.
        self.prepared_here()
        self.fails("watch.overlap", '{ limit = 0.05, do = "stop" }')
        self.assertGreater(self.last_step(), 1)
        self.assertEqual(list(self.samples.glob("*.hdf")), [], "it was loading already: the case is none")
        self.assertIn("overlap", self.restart(code=NUMERICAL, ranks=3).result.errors[0])
        self.assert_same(self.whole, self.restart("--set", "watch.overlap.do=warn", ranks=1), but=["scene.toml"])
        self.assert_same_samples()

    def prepared_here(self):
        self.samples = self.folder / "samples"

    def assert_same_samples(self):
        made, wanted = ([path.read_bytes() for path in folder.glob("*.hdf")] for folder in (self.samples, type(self).samples))
        self.assertEqual(made, wanted)

    def test_a_stage_that_takes_too_long_to_settle(self):
        self.prepared_here()
        key = "stages.settle.until.at_most"
        result = self.run_it("--set", f"{key}=1", code=NUMERICAL)
        self.assertIn("did not settle within 1 s", result.errors[0])
        self.assertIn(f"--set {key}=…", result.err)
        self.assertEqual(self.last_step(), 40, "1 s in steps of 0.025 s")
        self.assertIn("did not settle", self.restart(code=NUMERICAL).result.errors[0])
        self.assert_same(self.whole, self.restart("--set", f"{key}=1000", ranks=3), but=["scene.toml"])
        self.assert_same_samples()

    def test_warnings_change_nothing_and_are_counted_through_restarts(self):
        keys = ("--set", "watch.overlap.limit=0.01")
        result = self.run_it(*keys, out=self.folder / "warned")
        warned = Run(self.folder / "warned", result)
        self.assertEqual(warned.hash, self.whole.hash)
        self.assertGreater(warned.summary["watch"]["overlap"], 10)
        self.assertLess(result.err.count("warning: "), 20, "a line for every step")
        self.run_it(*keys, "--steps", "100")
        self.assertEqual(self.restart().summary["watch"], warned.summary["watch"])

    def test_substeps_are_the_same_on_any_number_of_ranks(self):
        keys = ("--set", "watch.overlap={ limit = 0.12, do = \"substep\" }")
        one = Run(self.folder / "one", self.run_it(*keys, ranks=1, out=self.folder / "one"))
        self.assertGreater(one.summary["watch"]["divided_steps"], 0)
        self.assertLess(one.summary["overlap_max_of_rows"], 0.12)
        self.run_it(*keys, "--steps", "77")
        run = self.restart(ranks=3)
        self.assertEqual(run.hash, one.hash)
        self.assertEqual(run.summary["watch"], one.summary["watch"])


class Clock(FaultTest):
    def test_goes_backwards(self):
        before = os.environ.get("LD_PRELOAD", "")
        os.environ["LD_PRELOAD"] = f"{os.environ['NAPPE_CLOCK']} {before}"
        try:
            result = finish(self.start("--checkpoint-every", "1s", ranks=0))
        finally:
            os.environ["LD_PRELOAD"] = before
        self.assertEqual(result.code, DONE, str(result))
        hours = {line[1:3] for line in result.err.splitlines() if line.startswith("[")}
        self.assertGreater(len(hours), 1, "the clock did not jump: the case is none")
        run = Run(self.out, result)
        self.assert_same(self.whole, run)
        self.assertGreater(run.summary["checkpoints"]["written"], 0)
        self.assertGreater(run.summary["seconds_total"], 0)
        self.assertLess(run.summary["seconds_total"], 300)


if __name__ == "__main__":
    main()
