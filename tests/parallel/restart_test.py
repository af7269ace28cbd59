"""A run that was stopped and went on, on other numbers of ranks too, leaves what one leaves that never stopped: state hash,
series, frames, measures."""

import json
import pathlib
import random
import shutil
import signal
import sys
import time

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parent.parent / "support"))
from nappe_driver import SCENES, Run, call, finish, main, sets, start  # noqa: E402
from same_files import SameFiles  # noqa: E402
from smooth_keys import SMOOTH  # noqa: E402

FOLD = SCENES / "small_fold.toml"
FAULT = SCENES / "small_fault.toml"
STOPPED = 3


class Restarts(SameFiles):
    def restart(self, out, *arguments, ranks=0, code=0):
        result = call(["restart", out, "--samples", self.folder / "samples", *arguments], ranks, self.folder)
        self.assertEqual(result.code, code, str(result))
        return Run(out, result)

    def checkpoints(self, out):
        return sorted((out / "checkpoints").glob("*.json"))

    def notes_kept(self, out):
        return [json.loads(path.read_text())["notes"] for path in self.checkpoints(out)]

    def steps_kept(self, out):
        return [notes["step"] for notes in self.notes_kept(out)]

    def in_parts(self, scene, stops, rank_counts, *arguments, whole=None):
        """The whole run on one rank, and the same in parts that end with the steps in `stops`."""
        whole = whole or self.run_scene(scene, *arguments, ranks=1, out="whole")
        shutil.rmtree(self.folder / "parts", ignore_errors=True)
        self.run_scene(scene, *arguments, "--steps", stops[0], ranks=rank_counts[0], out="parts")
        parts = self.folder / "parts"
        for k, ranks in enumerate(rank_counts[1:], 1):
            limit = ["--steps", stops[k]] if k < len(stops) else []
            run = self.restart(parts, *limit, ranks=ranks)
            self.assertIn(f"step {stops[k - 1]},", run.result.err)
        self.assertEqual(run.summary["restarts"], len(stops))
        self.assert_same(whole, run)
        return whole, run

    def test_anywhere_on_any_number_of_ranks(self):
        whole = None
        chance = random.Random(6)
        for ranks in ((1, 2, 3), (5, 1, 2), (3, 5, 1), (2, 2, 5)):
            stops = sorted(chance.sample(range(1, 60), 2))
            with self.subTest(stops=stops, ranks=ranks):
                whole, _ = self.in_parts(FOLD, stops, ranks, whole=whole)

    def test_step_by_step(self):
        # Between any two steps: before, at and after rebuilds, rows and frames.
        whole = self.run_scene(FOLD, "--steps", 25, ranks=1, out="whole")
        self.run_scene(FOLD, "--steps", 1, ranks=1, out="parts")
        for step in range(2, 26):
            run = self.restart(self.folder / "parts", "--steps", step, ranks=1 + step % 2)
        self.assertGreater(whole.summary["rebuilds"], 3, "lists never changed: the case is too easy")
        self.assert_same(whole, run)

    def test_cohesion_measures_and_energy(self):
        keys = sets(output__measures__during_run="true", output__measures__energy="true")
        self.in_parts(FAULT, (33, 77), (2, 3, 1), *keys)

    def test_grains_that_fly(self):
        whole, _ = self.in_parts(SCENES / "three_grains.toml", (17, 64), (1, 2, 3))
        self.assertGreater(whole.summary["relaxations"], 0)

    def test_every_way_to_solve(self):
        push = "stages__push__solver__"
        ways = [
            {push + "method": "ansgs"},
            {push + "method": "apgd", push + "sweeps": 25},
            {"solver__tolerance": 0.1, "solver__max_sweeps": 60, "solver__substeps": 2, "laws__0__restitution": 0.3},
            {
                push + "sweeps": 100,
                push + "adaptive": 1e-2,
                push + "substeps": 4,
                push + "geometry_every": 4,
                push + "position_correction": 0.2,
            },
            {"solver__precision": "single"},
            {push + "warm_start": "false", push + "sweeps": 60},
        ]
        for k, keys in enumerate(ways):
            with self.subTest(**keys):
                shutil.rmtree(self.folder / "whole", ignore_errors=True)
                whole = self.run_scene(FOLD, *sets(**keys), ranks=1, out="whole")
                self.in_parts(FOLD, (7 + 3 * k, 35 + k), (2, 3, 1), *sets(**keys), whole=whole)

    def test_smooth_contacts(self):
        # The tangential springs are what is not in positions and velocities.
        self.in_parts(FOLD, (333, 777), (2, 3, 1), *SMOOTH, *sets(stages__push__duration=0.1, tiles__skin=0.005, tiles__lookahead=1))

    def test_large_grains(self):
        fall = "stages__fall__solver__"
        for keys in ({}, {fall + "method": "cundall", fall + "h": 3e-5, "stages__fall__duration": 0.018}):
            with self.subTest(**keys):
                cuts = (201, 410) if keys else (17, 40)
                self.in_parts(SCENES / "small_rockfall.toml", cuts, (2, 3, 1), *sets(**keys))
                shutil.rmtree(self.folder / "whole", ignore_errors=True)

    def test_gauges_probes_and_energy(self):
        # Intervals of their own, which no stop falls on the end of; smooth contacts and rigid ones.
        keys = sets(
            output__gauges='[{ name = "slab", wall = "floor", bins = 9, every = 7 }, { name = "push", wall = "piston", to = 5.0 }]',
            output__probes='[{ name = "one", grain = 100, every = 3 }]',
            output__measures__energy="true",
        )
        whole, _ = self.in_parts(FOLD, (17, 32), (2, 3, 1), *keys)
        self.assertEqual(list(whole.series("gauge-slab")["step"])[:3], [0, 7, 14])
        smooth = [*keys, *SMOOTH, *sets(stages__push__duration=0.05, tiles__skin=0.005, tiles__lookahead=1)]
        shutil.rmtree(self.folder / "whole")
        whole, _ = self.in_parts(FOLD, (111, 333), (3, 1, 2), *smooth)
        self.assertGreater(whole.series("energy")["dashpot"][-1], 0)

    def test_prepared_by_springs(self):
        # Settled and loaded by springs, and settled by springs and loaded by sweeps; the first stop comes while it settles.
        settle = {
            "stages__settle__until": "{ kinetic = 1e-7, unbalanced = 3e-3 }",
            "stages__settle__solver": '{ method = "cundall", h = 2e-4 }',
            "materials__rock__damping": 3000,
        }
        springs = {f"laws__{k}__{key}": value for k in (0, 1) for key, value in (("type", "cundall"), ("k_n", 5e7))}
        for push in ({"method": '"cundall"', "h": 2e-4}, {"h": 0.025}):
            with self.subTest(**push):
                text = ", ".join(f"{key} = {value}" for key, value in push.items())
                keys = sets(**springs, **settle, stages__push__solver="{ " + text + " }", stages__push__duration=0.1)
                for name in ("whole", "samples", "other-samples", "out"):
                    shutil.rmtree(self.folder / name, ignore_errors=True)
                whole = self.run_scene(FOLD, *keys, ranks=1, out="whole", samples="other-samples")
                out = self.folder / "out"
                process = start(["run", FOLD, *keys, "--out", out, "--samples", self.folder / "samples",
                                 "--checkpoint-every", "100"], 2)  # fmt: skip
                self.stop(process, out, lambda: self.checkpoints(out))
                self.assertFalse((out / "series/front.csv").exists(), "it was loading already: the case is none")
                run = self.restart(out, ranks=3)
                self.assert_same(whole, run)
                self.assertEqual(run.summary["settle_steps"], whole.summary["settle_steps"])
                samples = [[p.read_bytes() for p in (self.folder / name).glob("*.hdf")] for name in ("samples", "other-samples")]
                self.assertEqual(samples[0], samples[1], "the sample differs")

    def test_coupled_once_a_sweep_on_the_same_ranks(self):
        # Here results follow from who owns which tiles; none may move, since when they do, clocks have a say.
        keys = sets(stages__push__solver__coupling="sweep", balance__threshold=1000)
        whole = self.run_scene(FOLD, *keys, ranks=3, out="whole")
        self.in_parts(FOLD, (13, 40), (3, 3, 3), *keys, whole=whole)
        self.run_scene(FOLD, *keys, "--steps", 13, ranks=3, out="other")
        other = self.restart(self.folder / "other", ranks=2)
        self.assertIn("results go on otherwise", other.result.err)
        self.assertNotEqual(other.hash, whole.hash)

    def stop(self, process, out, when):
        deadline = time.monotonic() + 120
        while not when() and process.poll() is None and time.monotonic() < deadline:
            time.sleep(0.02)
        process.send_signal(signal.SIGUSR1)
        result = finish(process)
        self.assertEqual(result.code, STOPPED, str(result))
        self.assertIn(f"go on with nappe restart {out}", result.err)

    def test_while_preparing(self):
        keys = sets(solver__sweeps=200)
        whole = self.run_scene(FOLD, *keys, ranks=1, out="whole", samples="other-samples")
        out = self.folder / "out"
        process = start(["run", FOLD, *keys, "--out", out, "--samples", self.folder / "samples",
                         "--checkpoint-every", "10"], 2)  # fmt: skip
        self.stop(process, out, lambda: self.checkpoints(out))
        self.assertFalse((out / "series/front.csv").exists(), "it was loading already: the case is none")
        self.assertGreater(self.steps_kept(out)[-1], 0)
        refused = call(["restart", out, *sets(solver__sweeps=150)], 2)
        self.assertEqual(refused.code, 2, str(refused))
        self.assertIn("what a sample is prepared by must be as the run began", refused.err)
        # As many steps of loading as of settling are another state: it is kept.
        kept = self.steps_kept(out)[-1]
        self.assertLess(kept, whole.summary["steps"], "it stopped too late: the case is none")
        shutil.copytree(out, self.folder / "copy")
        self.restart(self.folder / "copy", "--steps", kept, ranks=2)
        self.assertEqual(self.notes_kept(self.folder / "copy")[-1]["stage"], "push")
        shutil.rmtree(self.folder / "samples")
        run = self.restart(out, ranks=3)
        self.assert_same(whole, run)
        self.assertEqual(run.summary["settle_steps"], whole.summary["settle_steps"])
        self.assertIs(run.summary["sample_reused"], False)
        for name in ("samples", "other-samples"):
            samples = [p.read_bytes() for p in sorted((self.folder / name).glob("*.hdf"))]
            self.assertEqual(len(samples), 1)
            first = samples if name == "samples" else first  # noqa: F821
            self.assertEqual(samples, first, "the sample differs")

    def test_a_sample_made_by_coupling_once_a_sweep_stays_on_its_ranks(self):
        keys = sets(solver__coupling="sweep", balance__threshold=1000, watch__overlap='{ limit = 0.05, do = "stop" }')
        self.run_scene(FOLD, *keys, ranks=2, out="parts", code=4)
        parts = self.folder / "parts"
        other = self.restart(parts, *sets(watch__overlap__do="warn"), ranks=3, code=2)
        self.assertIn("must go on on 2 ranks while its sample is prepared", other.result.errors[0])
        self.assertEqual(list((self.folder / "samples").glob("*.hdf")), [])
        self.restart(parts, *sets(watch__overlap__do="warn"), ranks=2)

    def test_from_an_older_checkpoint_what_came_after_goes(self):
        whole = self.run_scene(FOLD, ranks=1, out="whole")
        self.run_scene(FOLD, "--steps", 33, "--checkpoint-every", 9, ranks=2, out="parts")
        parts = self.folder / "parts"
        self.assertEqual(self.steps_kept(parts), [27, 33])
        newest = self.checkpoints(parts)[-1].with_suffix(".hdf")
        newest.write_bytes(newest.read_bytes()[:-1])
        run = self.restart(parts, ranks=2)
        self.assertIn(f"not used: {newest} has", run.result.err)
        self.assertIn("step 27,", run.result.err)
        self.assert_same(whole, run)

    def test_the_last_two_are_kept(self):
        self.run_scene(FOLD, "--steps", 1, out="for-the-sample")
        run = self.run_scene(FOLD, "--checkpoint-every", 7)
        self.assertEqual(self.steps_kept(run.out), [49, 56])
        self.assertEqual(run.summary["checkpoints"]["written"], 8)
        size = (run.out / "checkpoints/checkpoint-000008.hdf").stat().st_size
        self.assertEqual(run.summary["checkpoints"]["bytes"], size)
        self.assertEqual(len(list((run.out / "checkpoints").iterdir())), 4)

    def test_never_writes_none(self):
        run = self.run_scene(FOLD, "--steps", 9, "--checkpoint-every", "never")
        self.assertEqual(self.checkpoints(run.out), [])

    def test_settings_may_change_the_state_may_not(self):
        self.run_scene(FOLD, "--steps", 30, out="parts")
        parts = self.folder / "parts"
        early = self.restart(parts, "--steps", 5, ranks=2, code=2)
        self.assertIn("--steps: must be at least 30", early.result.errors[0])
        before = {p: p.read_bytes() for p in parts.rglob("*") if p.is_file()}
        for keys, named in (
            (sets(sample__seed=9), "sample"),
            (sets(materials__rock__density=1), "materials"),
            (sets(walls__floor__points="[[0, 0], [41, 0]]"), "walls"),
            (sets(tiles__side=30), "tiles"),
            (sets(stages__push__solver__h=0.01), "solver.h of stage 'push' must be"),
            (sets(stages__push__duration=0.5), "must not end before the checkpoint, at step 30"),
        ):
            with self.subTest(named=named):
                run = self.restart(parts, *keys, ranks=2, code=2)
                self.assertIn(named, run.result.errors[0])
                self.assertEqual({p: p.read_bytes() for p in parts.rglob("*") if p.is_file()}, before)
        run = self.restart(parts, *sets(stages__push__duration=2.0, stages__push__solver__sweeps=33))
        self.assertEqual(run.summary["steps"], 80)
        self.assertEqual(run.series("solver")["sweeps"][-1], 33)
        self.assertIn("sweeps = 33", (parts / "scene.toml").read_text())

    def test_a_run_at_its_end_is_left_alone(self):
        run = self.run_scene(FOLD, "--checkpoint-every", 20)
        before = {p: p.read_bytes() for p in run.out.rglob("*") if p.is_file()}
        for keys in ([], sets(output__frames__every=30)):  # as the scene has it
            self.assertIn("nothing to do", self.restart(run.out, *keys, ranks=2).result.err)
        self.assertEqual({p: p.read_bytes() for p in run.out.rglob("*") if p.is_file()}, before)


if __name__ == "__main__":
    main()
