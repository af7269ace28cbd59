"""The folder of a run: who else is in it, what lies there already, what becomes of it meanwhile, and limits on its files."""

import os
import resource
import shutil
import signal
import subprocess

from processes import ranks_of
from run_kit import BAD_INPUT, FOLD, LONG, MOST, OTHER, STOPPED, FaultTest, call, paths, sets, start

from nappe_driver import Run, finish, main


class Folders(FaultTest):
    def test_what_is_not_ours_stays(self):
        self.out.mkdir()
        scene = self.out / "scene.toml"
        scene.write_text("# mine\n" + FOLD.read_text())
        for arguments in (["run", scene, *LONG], ["run", FOLD, *LONG], ["run", scene, *LONG, "--overwrite"]):
            result = call([*arguments, "--out", self.out, "--samples", self.samples])
            self.assertEqual(result.code, BAD_INPUT, str(result))
            self.assertIn("scene.toml", result.errors[0])
            self.assertTrue(scene.read_text().startswith("# mine"))
        scene.unlink()
        (self.out / "frames").mkdir()
        mine = [self.out / "notes.part-2.txt", self.out / "frames/movie.part-1.mp4", self.out / "thesis.part-1.toml"]
        for path in mine:
            path.write_text("mine")
        self.run_it()
        for path in mine:
            self.assertTrue(path.exists(), path)

    def test_results_are_not_run_over_or_mixed(self):
        self.run_it("--set", "output.frames.every=7")
        before = self.contents()
        result = self.run_it("--set", "sample.seed=8", code=BAD_INPUT)
        self.assertIn("must not hold the results of another run", result.errors[0])
        self.assertEqual(self.contents(), before)
        result = self.run_it("--overwrite")
        self.assertEqual(Run(self.out, result).files(), self.whole.files(), "frames of two runs")

    def test_frames_without_a_checkpoint_are_not_run_over(self):
        process = self.start("--checkpoint-every", "never")
        self.wait(process, lambda: len(list((self.out / "frames").glob("*.hdf"))) > 1)
        for pid in ranks_of(process.pid, paths.nappe):
            os.kill(pid, signal.SIGKILL)
        finish(process, MOST)
        (self.out / ".lock").unlink()  # of the dead
        before = self.contents()
        self.assertIn("found its frames, and no checkpoint", self.run_it(code=BAD_INPUT).errors[0])
        self.assertEqual(self.contents(), before)
        (self.out / "summary.json").write_text("{}")
        shutil.rmtree(self.out / "frames")
        self.assert_same(self.whole, Run(self.out, self.run_it("--overwrite")))

    def test_a_kernel_that_one_machine_does_not_have(self):
        run = [paths.nappe, "run", FOLD, *LONG, "--out", self.out, "--kernel"]
        command = [paths.mpirun, "-n", "1", *run, "portable", ":", "-n", "1", *run, "avx4096"]
        done = subprocess.run(list(map(str, command)), capture_output=True, text=True, timeout=MOST)
        self.assertEqual(done.returncode, BAD_INPUT, done.stderr)
        self.assertEqual(done.stderr.count("avx4096"), 1, done.stderr)
        self.assertFalse(self.out.exists())

    def test_a_stop_while_preparing_that_can_not_be_kept(self):
        # What was kept before stands: the run can go on, and a batch script must know.
        self.samples = self.folder / "samples"
        process = self.start("--checkpoint-every", "3", "--set", "solver.sweeps=300")
        self.wait(process, lambda: len(self.checkpoints()) == 2)
        ranks = ranks_of(process.pid, paths.nappe)
        for pid in ranks:
            resource.prlimit(pid, resource.RLIMIT_FSIZE, (2000, 2000))
        os.kill(ranks[0], signal.SIGUSR1)
        result = finish(process, MOST)
        self.assertEqual(result.code, STOPPED, str(result))
        self.assertIn("stopped while preparing, and this state is in no checkpoint; nappe restart", result.err)
        self.assertGreater(len(self.checkpoints()), 0)

    def test_what_a_restart_is_told_outlives_it(self):
        self.run_it("--steps", "20")
        process = start(["restart", self.out, "--samples", self.samples, "--set", "stages.push.solver.sweeps=12"], 2,
                        LD_PRELOAD=f"{os.environ['NAPPE_SLOW_NETWORK']} {os.environ.get('LD_PRELOAD', '')}")  # fmt: skip
        self.wait(process, lambda: self.last_step() > 20)
        for pid in ranks_of(process.pid, paths.nappe):
            os.kill(pid, signal.SIGKILL)
        finish(process, MOST)
        self.assertIn("sweeps = 12", self.restart().summary["scene"])

    def test_a_limit_on_the_size_of_files(self):
        # A frame has 70 kB. For nappe alone: shared memory of mpirun's own is of files that are larger.
        limited = ["bash", "-c", 'ulimit -f 50; exec "$0" "$@"', paths.nappe, "run", FOLD, *LONG, "--out", self.out]
        command = [paths.mpirun, "-n", "2", "--mca", "btl", "self,tcp", *limited, "--samples", self.samples]
        done = subprocess.run(list(map(str, command)), capture_output=True, text=True, timeout=MOST)
        self.assertEqual(done.returncode, OTHER, done.stderr)
        self.assertIn("raise the limit on the size of files (ulimit -f)", done.stderr)

    def test_two_runs_in_one_folder(self):
        first = self.start(*sets(stages__push__duration=2000, walls__piston__motion__velocity="[0.001, 0]"),
                           "--checkpoint-every", "20")  # fmt: skip
        self.wait(first, self.checkpoints)
        try:
            for arguments in (
                ["run", FOLD, *LONG, "--out", self.out],
                ["run", FOLD, *LONG, "--out", self.out, "--overwrite"],
                ["restart", self.out],
            ):
                second = call([*arguments, "--samples", self.samples], 2)
                self.assertEqual(second.code, BAD_INPUT, str(second))
                self.assertEqual(len(second.errors), 1, second.err)
                self.assertIn("must be used by one run at a time, found process", second.errors[0])
            self.assertIn("running: process", call(["info", self.out]).out)
        finally:
            first.send_signal(signal.SIGUSR1)
            result = finish(first)
        self.assertEqual(result.code, 3, str(result))
        self.assertIn("stopped early; nappe restart goes on", call(["info", self.out]).out)
        self.assertEqual(self.restart("--steps", self.last_step() + 5).summary["restarts"], 1)

    def test_an_unfinished_run_is_not_run_over(self):
        process = self.start("--checkpoint-every", "5")
        self.wait(process, self.checkpoints)
        process.send_signal(signal.SIGUSR1)
        finish(process)
        before = self.contents()
        result = self.run_it(code=BAD_INPUT)
        self.assertIn(f"go on with nappe restart {self.out}", result.errors[0])
        self.assertEqual(self.contents(), before)
        result = self.run_it("--overwrite")
        run = Run(self.out, result)
        self.assertEqual(run.hash, self.whole.hash)
        self.assertEqual(run.series("front"), self.whole.series("front"))
        self.assertEqual(self.checkpoints(), [], "a restart would go on with the run that was thrown away")

    def test_the_folder_vanishes(self):
        process = self.start("--checkpoint-every", "5")
        self.wait(process, lambda: self.rows() > 3)
        self.out.rename(self.folder / "elsewhere")
        result = finish(process, MOST)
        self.assertEqual(result.code, OTHER, str(result))
        self.assertEqual(len(result.errors), 1, result.err)
        # Most often it is to create the folder; but the folder may go while a file is in the making.
        self.assertIn("No such file or directory", result.errors[0])
        (self.folder / "elsewhere").rename(self.out)
        self.assertEqual(self.restart("--steps", self.last_step() + 5).summary["restarts"], 1)

    def test_too_many_open_files(self):
        cells = ", ".join(f'{{ name = "c{k}", centre = [{k}, 1], radius = 1 }}' for k in range(60))
        soft, hard = resource.getrlimit(resource.RLIMIT_NOFILE)
        for ranks in (0, 2):
            with self.subTest(ranks=ranks):
                self.fresh()
                resource.setrlimit(resource.RLIMIT_NOFILE, (60 if ranks == 0 else 72, hard))
                try:
                    process = self.start("--set", f"output.cells=[{cells}]", ranks=ranks)
                finally:
                    resource.setrlimit(resource.RLIMIT_NOFILE, (soft, hard))
                result = finish(process, MOST)
                self.assertEqual(result.code, OTHER, str(result))
                self.assertIn("raise the limit on open files (ulimit -n)", result.err)


if __name__ == "__main__":
    main()
