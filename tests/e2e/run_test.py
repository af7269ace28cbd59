"""`nappe run` as its users and their scripts see it: exit codes, messages, overrides, stops and stored samples."""

import pathlib
import re
import shutil
import signal
import sys
import time

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parent.parent / "support"))
from nappe_driver import SCENES, NappeTest, Run, call, finish, main, sets, start  # noqa: E402

import h5py  # noqa: E402

FOLD = SCENES / "small_fold.toml"
THROWN = SCENES / "three_grains.toml"
DONE, OTHER, BAD_INPUT, STOPPED, NUMERICAL = 0, 1, 2, 3, 4


class CommandLine(NappeTest):
    def test_help_lists_commands_and_exit_codes(self):
        result = call(["--help"])
        self.assertEqual(result.code, DONE)
        codes = ("0 done", "1 anything else", "2 bad input", "3 stopped early", "4 numerical failure")
        for word in ("run", "check", "trade", "measure", *codes):
            self.assertIn(word, result.out)
        result = call(["run", "--help"])
        self.assertEqual(result.code, DONE)
        for option in ("--out", "--samples", "--steps", "--set", "--kernel"):
            self.assertIn(option, result.out)
        result = call(["--version"])
        self.assertEqual(result.code, DONE)
        self.assertRegex(result.out.strip(), r"^\d+\.\d+\.\d+$")

    def test_help_is_printed_once_on_two_ranks(self):
        result = call(["--help"], ranks=2)
        self.assertEqual(result.code, DONE)
        self.assertEqual(result.out.count("Exit codes:"), 1)

    def bad_inputs(self):
        """What is wrong, and what the message must name."""
        bad = self.folder / "bad.toml"
        text = FOLD.read_text().replace("min = 0.42", "min = -0.42")
        bad.write_text(text)
        line = 1 + [k for k, t in enumerate(text.splitlines()) if "-0.42" in t][0]
        broken = self.folder / "broken.toml"
        broken.write_text("[world\n")
        return [
            ([], "subcommand"),
            (["rub", FOLD], "subcommand"),
            (["run"], "scene"),
            (["run", FOLD, "--bananas"], "--bananas"),
            (["run", FOLD, "--steps", "-1"], "--steps"),
            (["run", FOLD, "--steps", "many"], "--steps"),
            (["run", self.folder / "missing.toml"], "missing.toml"),
            (["run", self.folder], str(self.folder)),
            (["run", bad], f"bad.toml:{line}: sample.radius.min"),
            (["run", broken], "broken.toml:1"),
            (["run", FOLD, *sets(solver__bananas=3)], "solver.bananas"),
            (["run", FOLD, *sets(solver__h=-1)], "solver.h"),
            (["run", FOLD, *sets(solver__h="fast")], "solver.h"),
            (["run", FOLD, *sets(walls__ceiling__points="[[0, 0], [1, 1]]")], "ceiling"),
            (["run", FOLD, "--set", "solver.h"], "solver.h"),
            (["run", FOLD, *sets(tiles__side=1.0)], "tiles.side"),
            (["run", FOLD, "--kernel", "abacus"], "--kernel: must name"),
            (["check", bad], "sample.radius.min"),
            (["check", FOLD, "--ranks", "0"], "--ranks"),
        ]

    def test_bad_input_is_code_2_before_anything_is_written(self):
        for arguments, named in self.bad_inputs():
            with self.subTest(arguments=[str(a) for a in arguments]):
                before = sorted(self.folder.rglob("*"))
                result = call(arguments, folder=self.folder)
                self.assertEqual(result.code, BAD_INPUT, str(result))
                self.assertIn(named, result.err)
                self.assertEqual(sorted(self.folder.rglob("*")), before, "something was written")

    def test_bad_input_on_two_ranks_is_said_once(self):
        bad = self.bad_inputs()
        for arguments, named in (bad[3], bad[6], bad[8], bad[10], bad[16]):
            with self.subTest(arguments=[str(a) for a in arguments]):
                result = call(arguments, ranks=2, folder=self.folder)
                self.assertEqual(result.code, BAD_INPUT, str(result))
                said = [line for line in result.err.splitlines() if named in line]
                self.assertEqual(len(said), 1, result.err)


class Failures(NappeTest):
    def test_grain_too_fast_for_tiles_is_code_4_on_one_and_two_ranks(self):
        for ranks in (0, 1, 2):
            with self.subTest(ranks=ranks):
                run = self.run_scene(
                    THROWN, *sets(grains__0__velocity="[1e5, 0]"), ranks=ranks, out=f"out-{ranks}", code=NUMERICAL
                )
                self.assertEqual(len(run.result.errors), 1, run.result.err)
                self.assertIn("grain 0", run.result.errors[0])
                self.assertIn("solver.h", run.result.errors[0])
                self.assertNotIn("summary.json", run.files())
                self.assertEqual([f for f in run.files() if ".part-" in f], [])

    def test_sample_that_does_not_settle_is_code_4(self):
        until = "{ kinetic = 1e-30, residual = 1e-30, at_most = 0.5 }"
        run = self.run_scene(FOLD, *sets(stages__settle__until=until), ranks=2, code=NUMERICAL)
        self.assertEqual(len(run.result.errors), 1, run.result.err)
        self.assertIn("stage 'settle' did not settle", run.result.errors[0])
        found = [path.relative_to(run.out).parts[0] for path in run.out.rglob("*") if path.is_file()]
        self.assertEqual(set(found), {"checkpoints"}, "there is no result, but a restart goes on")
        stored = [path for path in self.folder.rglob("*.hdf") if path.parent.name != "checkpoints"]
        self.assertEqual(stored, [], "a sample that is not settled was stored")

    def test_probe_of_a_grain_that_is_not_there_is_code_2(self):
        # The deposit tells how many there are; nothing is settled before.
        scene = self.folder / "far.toml"
        text = FOLD.read_text().replace("[output]\n", '[output]\nprobes = [{ name = "far", grain = 100000 }]\n')
        scene.write_text(text)
        line = 1 + [k for k, t in enumerate(text.splitlines()) if "far" in t][0]
        for ranks in (0, 2):
            with self.subTest(ranks=ranks):
                run = self.run_scene(scene, ranks=ranks, out=f"far-{ranks}", code=BAD_INPUT)
                said = re.search(r"far.toml:(\d+): output.probes.far.grain: must be < (\d+), .* found 100000; (.*)", run.result.err)
                self.assertIsNotNone(said, run.result.err)
                self.assertEqual(int(said[1]), line)
                self.assertGreater(int(said[2]), 100)
                self.assertIn("[[grains]]", said[3])
                self.assertNotIn("settled after", run.result.err)

    def test_output_folder_that_can_not_be_made_is_code_1(self):
        (self.folder / "file").write_text("not a folder")
        for ranks in (0, 2):
            with self.subTest(ranks=ranks):
                run = self.run_scene(FOLD, ranks=ranks, out="file/out", code=OTHER)
                self.assertEqual(len(run.result.errors), 1, run.result.err)
                self.assertIn("file/out", run.result.errors[0])
                self.assertEqual(list(self.folder.rglob("*.hdf")), [], "found out only after the work of settling")
        self.assertEqual((self.folder / "file").read_text(), "not a folder")

    def test_sample_folder_that_can_not_be_made_is_code_1(self):
        (self.folder / "file").write_text("not a folder")
        run = self.run_scene(FOLD, ranks=2, samples="file/samples", code=OTHER)
        self.assertEqual(len(run.result.errors), 1, run.result.err)
        self.assertIn("file/samples", run.result.errors[0])


class Stops(NappeTest):
    def stop(self, number, ranks, *arguments, when):
        """Starts a run that would take hours, waits until when() holds, and sends the signal."""
        process = start(
            ["run", FOLD, "--out", self.folder / "out", "--samples", self.folder / "samples", *arguments], ranks
        )
        deadline = time.monotonic() + 120
        while not when() and process.poll() is None and time.monotonic() < deadline:
            time.sleep(0.05)
        process.send_signal(number)
        return finish(process)

    def rows(self, name="front"):
        file = self.folder / "out" / "series" / f"{name}.csv"
        return len(file.read_text().splitlines()) if file.exists() else 0

    def test_signals_end_a_run_whole_with_code_3(self):
        for number, ranks in ((signal.SIGUSR1, 0), (signal.SIGTERM, 0), (signal.SIGINT, 1), (signal.SIGUSR1, 2)):
            with self.subTest(signal=number.name, ranks=ranks):
                if number == signal.SIGINT:
                    ranks = 0  # mpirun turns INT and TERM into a kill
                shutil.rmtree(self.folder / "out", ignore_errors=True)
                result = self.stop(number, ranks, *sets(stages__push__duration=20), when=lambda: self.rows() > 2)
                self.assertEqual(result.code, STOPPED, str(result))
                run = Run(self.folder / "out", result)
                self.assertIs(run.summary["stopped_early"], True)
                steps = run.summary["steps"]
                self.assertLess(steps, 800)
                with h5py.File(run.out / f"frames/frame-{steps:08}.hdf") as frame:
                    self.assertEqual(frame.attrs["step"], steps)
                    self.assertEqual(len(frame["VTKHDF/Points"]), run.summary["grains"])
                self.assertIn(f"frame-{steps:08}.hdf", (run.out / "run.xdmf").read_text())
                self.assertEqual([f for f in run.files() if ".part-" in f], [])

    def test_stop_while_preparing_leaves_a_checkpoint(self):
        # So many sweeps that a step takes about a tenth of a second: even a grain's last motion (it does come to rest, to
        # the last bit) is then minutes away when the signal comes.
        until = "{ kinetic = 1e-30, residual = 1e-30 }"
        for every, left in (("10min", ["checkpoint-000001.hdf", "checkpoint-000001.json"]), ("never", [])):
            with self.subTest(checkpoint_every=every):
                begun = time.monotonic()
                result = self.stop(
                    signal.SIGUSR1,
                    2,
                    *sets(stages__settle__until=until, solver__sweeps=20000),
                    "--checkpoint-every",
                    every,
                    "--overwrite",
                    when=lambda begun=begun: time.monotonic() > begun + 4,
                )
                self.assertEqual(result.code, STOPPED if left else OTHER, str(result))
                self.assertIn("go on with nappe restart" if left else "there is no checkpoint", result.err)
                self.assertEqual(sorted(p.name for p in self.folder.rglob("*") if p.is_file()), left)


class Options(NappeTest):
    def test_steps_ends_the_run_there(self):
        for steps in (0, 7):
            with self.subTest(steps=steps):
                run = self.run_scene(FOLD, "--steps", steps, out=f"out-{steps}")
                self.assertEqual(run.summary["steps"], steps)
                self.assertAlmostEqual(run.summary["time_simulated"], 0.025 * steps)
                self.assertIs(run.summary["stopped_early"], False)
                self.assertIn(f"frames/frame-{steps:08}.hdf", run.files())
                self.assertEqual(run.series("front")["step"][-1], steps)

    def test_the_first_steps_do_not_depend_on_how_many_follow(self):
        run = self.run_scene(FOLD, "--steps", 30, out="short")
        whole = self.run_scene(FOLD, out="whole")
        frame = "frames/frame-00000030.hdf"
        with h5py.File(run.out / frame) as a, h5py.File(whole.out / frame) as b:
            for name in ("VTKHDF/Points", "VTKHDF/PointData/velocity", "contacts/r_n", "contacts/r_t"):
                self.assertEqual(a[name][()].tobytes(), b[name][()].tobytes(), name)

    def test_default_folders(self):
        result = call(["run", THROWN, "--steps", "1"], folder=self.folder)
        self.assertEqual(result.code, DONE, str(result))
        self.assertTrue((self.folder / "out/three_grains/summary.json").is_file())

    def test_set_changes_the_run_and_the_last_of_two_counts(self):
        plain = self.run_scene(FOLD, "--steps", 5, out="plain")
        more = self.run_scene(FOLD, "--steps", 5, *sets(stages__push__solver__sweeps=11), out="more")
        both = sets(stages__push__solver__sweeps=3) + sets(stages__push__solver__sweeps=11)
        twice = self.run_scene(FOLD, "--steps", 5, *both, out="twice")
        self.assertNotEqual(more.hash, plain.hash)
        self.assertEqual(twice.hash, more.hash)
        self.assertEqual(more.series("solver")["sweeps"][-1], 11)

    def test_scene_of_the_summary_gives_the_same_run(self):
        keys = sets(solver__sweeps=7, walls__piston__motion__velocity="[0.5, 0.0]", title="'as run'")
        first = self.run_scene(FOLD, "--steps", 20, *keys, out="first", samples="samples-1")
        again = self.folder / "again.toml"
        again.write_text(first.summary["scene"])
        second = self.run_scene(again, "--steps", 20, out="second", samples="samples-2")
        self.assertEqual(second.hash, first.hash)
        self.assertEqual(second.summary["title"], "as run")
        self.assertEqual(second.summary["scene"], first.summary["scene"])


class OldResults(NappeTest):
    def test_nothing_of_an_older_run_passes_for_the_new_one(self):
        out = self.folder / "out"
        first = call(["run", FOLD, "--out", out, "--steps", 2])
        self.assertEqual(first.code, DONE, first)
        self.assertTrue((out / "summary.json").exists())
        # This one ends before it has results: its grains can not settle in no time.
        second = call(["run", FOLD, "--out", out, "--overwrite", "--samples", self.folder / "other",
                       *sets(stages__settle__until__at_most=0.001)])
        self.assertEqual(second.code, NUMERICAL, second)
        for name in ("summary.json", "run.xdmf", "contacts.xdmf", "scene.toml"):
            self.assertFalse((out / name).exists(), name)


class StoredSamples(NappeTest):
    def run_fold(self, out, *arguments, ranks=0):
        return self.run_scene(FOLD, "--steps", 10, *arguments, out=out, ranks=ranks)

    def test_second_run_uses_the_sample_and_gives_the_same_bits(self):
        first, second = self.run_fold("first", ranks=2), self.run_fold("second", ranks=2)
        self.assertIs(first.summary["sample_reused"], False)
        self.assertIs(second.summary["sample_reused"], True)
        self.assertEqual(second.hash, first.hash)
        for path in sorted((first.out / "series").iterdir()):
            self.assertEqual((second.out / "series" / path.name).read_bytes(), path.read_bytes(), path.name)
        self.assertEqual(second.summary["rebalanced"], first.summary["rebalanced"])

    def test_only_what_determines_a_sample_makes_it_anew(self):
        self.run_fold("first")
        other_output = "[{ name = 'other', centre = [20, 2], radius = 2 }]"
        for key, value in (("output__cells", other_output), ("output__frames__every", 3), ("balance__every", 7),
                           ("title", "'other'"), ("stages__push__duration", 3), ("stages__push__solver__h", 0.02),
                           ("walls__piston__motion__velocity", "[2, 0]"), ("walls__floor__name", "'ground'")):
            with self.subTest(key=key):
                self.assertIs(self.run_fold(f"out-{key}", *sets(**{key: value})).summary["sample_reused"], True)
        for key, value in (("sample__seed", 4), ("laws__0__friction", 0.3), ("solver__sweeps", 11), ("tiles__side", 4),
                           ("materials__rock__density", 2700), ("stages__settle__until__kinetic", 2e-4),
                           ("world__gravity", "[0, -9.8]"), ("sample__layers__count", 4), ("solver__theta", 0.6)):
            with self.subTest(key=key):
                self.assertIs(self.run_fold(f"out-{key}", *sets(**{key: value})).summary["sample_reused"], False)

    def test_damaged_sample_is_made_again(self):
        first = self.run_fold("first")
        (path,) = (self.folder / "samples").glob("*.hdf")
        whole = path.read_bytes()
        middle = len(whole) // 2
        for name, damaged in (
            ("one bit", whole[:middle] + bytes([whole[middle] ^ 1]) + whole[middle + 1 :]),
            ("cut short", whole[:middle]),
            ("emptied", b""),
        ):
            with self.subTest(damage=name):
                path.write_bytes(damaged)
                again = self.run_fold(f"again-{name}", ranks=2)
                self.assertIs(again.summary["sample_reused"], False)
                self.assertEqual(again.hash, first.hash)
                self.assertEqual(path.read_bytes(), whole)
        manifest = path.with_suffix(".json")
        manifest.write_text("{}")
        self.assertEqual(self.run_fold("again").hash, first.hash)
        self.assertEqual(sorted(p.suffix for p in path.parent.iterdir()), [".hdf", ".json"], "something else is left")


if __name__ == "__main__":
    main()
