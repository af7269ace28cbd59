"""The same bits on any number of ranks, through the whole program: state hash, series, frames (but for the owning rank)
and stored samples of small scenes, with tiles changing hands all the time."""

import os
import pathlib
import shutil
import sys
import unittest

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parent.parent / "support"))
from gas_of_springs import gas, row  # noqa: E402
from nappe_driver import SCENES, main, sets  # noqa: E402
from same_files import SameFiles  # noqa: E402
from smooth_keys import SMOOTH  # noqa: E402

import h5py  # noqa: E402
import numpy as np  # noqa: E402

FOLD = SCENES / "small_fold.toml"


def kernels_here():
    """Instruction sets that this machine has, the fastest last."""
    flags = pathlib.Path("/proc/cpuinfo").read_text()
    needs = {"scalar": "", "portable": "", "avx2": " avx2 ", "avx512": " avx512vl "}
    return [kernel for kernel, flag in needs.items() if flag in flags]


KERNELS = kernels_here()


def here(rank_counts):
    """Fewer under sanitizers (tools/test)."""
    return [n for n in rank_counts if n <= int(os.environ.get("NAPPE_MOST_RANKS", "7"))]


def owners(path):
    with h5py.File(path, "r") as file:
        return file["VTKHDF/PointData/rank"][()]


class SameBits(SameFiles):
    def runs(self, scene, rank_counts, *arguments):
        """The run on one rank with the fastest kernel, and those on more, each with its own sample and the next kernel in
        turn: every case meets every instruction set."""
        self.assertGreaterEqual(len(rank_counts), len(KERNELS))
        one = self.run_scene(scene, *arguments, ranks=1, out="out-1", samples="samples-1")
        self.assertEqual(one.summary["kernel"], KERNELS[-1])
        yield 1, one
        for n in here(rank_counts):
            kernel = KERNELS[rank_counts.index(n) % len(KERNELS)]
            with self.subTest(ranks=n, kernel=kernel):
                folders = {"out": f"out-{n}", "samples": f"samples-{n}"}
                many = self.run_scene(scene, "--kernel", kernel, *arguments, ranks=n, **folders)
                self.assertEqual(many.summary["ranks"], n)
                self.assertEqual(many.summary["kernel"], kernel)
                self.assert_same(one, many)
                self.assert_same_samples("samples-1", f"samples-{n}")
                yield n, many

    def assert_same_samples(self, one, many):
        names = lambda folder: sorted(p.name for p in (self.folder / folder).glob("*"))  # noqa: E731
        self.assertEqual(names(many), names(one))
        for name in names(one):
            a, b = (self.folder / f / name for f in (one, many))
            self.assertEqual(b.read_bytes(), a.read_bytes(), f"sample {name}")

    def test_many_tiles_that_change_hands(self):
        for n, run in self.runs(FOLD, (2, 3, 5, 7)):
            first, last = owners(run.out / "frames/frame-00000000.hdf"), owners(run.out / "frames/frame-00000060.hdf")
            self.assertEqual(set(last), set(range(n)), "a rank is idle: the case is too easy")
            if n > 1:
                self.assertGreater(run.summary["rebalanced"], 1)
                self.assertGreater(np.count_nonzero(first != last), 0, "no grain changed hands: the case is too easy")

    def test_tiles_that_move_by_measured_time(self):
        keys = sets(balance__by="time", balance__threshold=1.0)
        for n, run in self.runs(FOLD, (2, 3, 5, 7), *keys):
            if n > 1:
                self.assertGreater(run.summary["rebalanced"], 0, "no tile moved: the case is too easy")

    def test_cohesion_and_a_plate_that_leaves_another(self):
        keys = sets(output__measures__during_run="true", output__measures__energy="true")
        for _, run in self.runs(SCENES / "small_fault.toml", (2, 3, 5, 7), *keys):
            with h5py.File(run.out / "frames/frame-00000120.hdf") as file:
                bond, r_n = file["contacts/bond"][()], file["contacts/r_n"][()]
            self.assertLessEqual({1, 2}, set(bond), "a state of the graph was not met")
            self.assertLess(r_n.min(), 0, "nothing pulls: the case is too easy")
            self.assertGreater(run.summary["rebuilds"], 5)

    def test_fewer_tiles_than_ranks(self):
        for n, run in self.runs(FOLD, (2, 3, 5, 7), *sets(tiles__side=30)):
            last = owners(run.out / "frames/frame-00000060.hdf")
            self.assertEqual(len(set(last)), min(n, 2), "40 m are two tiles of 30 m")

    def test_fewer_grains_than_ranks(self):
        for n, run in self.runs(SCENES / "three_grains.toml", (2, 3, 5, 7)):
            last = owners(run.out / "frames/frame-00000120.hdf")
            self.assertEqual(len(last), 3)
            if n > 1:
                self.assertGreater(len(set(last)), 1, "one rank has it all: the case is too easy")
            self.assertGreater(run.summary["relaxations"], 0, "nothing touched: the case is too easy")

    def test_tolerance_substeps_and_restitution(self):
        # All that steers by sums over ranks: V, the residual, and with it the number of sweeps.
        keys = sets(solver__tolerance=0.1, solver__max_sweeps=60, solver__substeps=2, laws__0__restitution=0.3)
        for _, run in self.runs(FOLD, (2, 3, 5, 7), *keys):
            self.assertGreater(len(set(run.series("solver")["sweeps"][1:])), 1, "the tolerance never acted")

    def test_methods_that_look_back(self):
        # Their momentum hangs on sums over all contacts of all ranks.
        for method, ranks in (("ansgs", (2, 3, 5, 7)), ("nncg", (5, 2, 7, 3)), ("apgd", (3, 5, 2, 7)), ("cpg", (7, 5, 3, 2))):
            keys = sets(stages__push__solver__method=method, stages__push__solver__sweeps=25)
            for _, run in self.runs(FOLD, ranks, "--steps", "20", *keys):
                self.assertGreater(run.summary["reductions"], 0)

    def test_quiet_tiles_kept_geometry_and_corrected_positions(self):
        keys = sets(
            stages__push__solver__sweeps=100,
            stages__push__solver__adaptive=1e-2,
            stages__push__solver__substeps=4,
            stages__push__solver__geometry_every=4,
            stages__push__solver__position_correction=0.2,
        )
        for _, run in self.runs(FOLD, (2, 3, 5, 7), *keys):
            full = run.summary["sweeps"] * run.summary["candidates"]
            self.assertLess(run.summary["relaxations"], 0.8 * full, "no tile was left alone: the case is too easy")
            self.assertGreater(run.summary["correction_work"], 0)

    def test_bonds_kept_with_their_geometry(self):
        keys = sets(
            stages__push__solver__adaptive=3e-3,
            stages__push__solver__substeps=5,
            stages__push__solver__geometry_every=5,
            laws__0__type="cohesive",
            laws__0__gamma=2e4,
            laws__0__d_w=0.02,
            tiles__skin=0.01,
            tiles__lookahead=1,
        )
        for _, run in self.runs(FOLD, (2, 3, 5, 7), *keys):
            self.assertGreater(run.summary["redone_groups"], 0, "no group was done again: the case is too easy")

    def test_smooth_contacts(self):
        keys = [*SMOOTH, *sets(stages__push__duration=0.1, tiles__skin=0.005, tiles__lookahead=1)]
        for n, run in self.runs(FOLD, (2, 3, 5, 7), *keys):
            self.assertEqual(run.summary["steps"], 1000)
            self.assertEqual(run.summary["sweeps"], 1000 + run.summary["redone_lists"], "something was solved for")
            self.assertGreater(run.summary["rebuilds"], 3)
            if n > 1:
                self.assertGreater(run.summary["rebalanced"], 0, "no tile moved: the case is too easy")

    def test_springs_that_fly(self):
        # Close together: lanes run out while springs are stretched. Far apart: grains are moved by another rank's contacts
        # in tiles whose turn is late.
        for columns, rows, spacing in ((14, 10, 2.6), (60, 6, 7)):
            with self.subTest(spacing=spacing):
                shutil.rmtree(self.folder / "samples-1", ignore_errors=True)
                scene = self.folder / "gas.toml"
                scene.write_text(gas(columns, rows, spacing, seed=2))
                for n, run in self.runs(scene, (2, 3, 5, 7)):
                    self.assertGreater(run.summary["rebuilds"], 100)
                    self.assertEqual(len(set(owners(run.out / "frames/frame-00000000.hdf"))), n, "a rank is idle")

    def test_frames_of_springs(self):
        # What frames say of contacts does not depend on which rank had a reason to look at a step closely.
        scene = self.folder / "row.toml"
        scene.write_text(row(40))
        for n, run in self.runs(scene, (2, 3, 5, 7)):
            self.assertEqual(len(list((run.out / "frames").glob("*.hdf"))), 201)

    def partners_of_last(self, run, n):
        """The most that each of the last n grains touched in some frame."""
        most = np.zeros(n, int)
        for path in (run.out / "frames").glob("*.hdf"):
            with h5py.File(path, "r") as frame:
                data = frame["VTKHDF/PointData"]
                most = np.maximum(most, data["coordination"][()][np.argsort(data["id"][()])][-n:])
        return most

    def test_large_grains(self):
        fall = "stages__fall__solver__"
        smooth = sets(**{fall + "method": "cundall", fall + "h": 3e-5, "stages__fall__duration": 0.009})
        all_at_once = {fall + "method": "nncg", fall + "tolerance": 1e-3, fall + "max_sweeps": 60}
        all_at_once |= {fall + "substeps": 4, fall + "geometry_every": 2, fall + "position_correction": 0.2}
        ways = {"nsgs": [], "cundall": smooth, "all at once": sets(**all_at_once)}
        for way, keys in ways.items():
            with self.subTest(way=way):
                shutil.rmtree(self.folder / "samples-1", ignore_errors=True)
                ranks = (2, 3, 5, 7)
                for n, run in self.runs(SCENES / "small_rockfall.toml", ranks, *keys):
                    self.assertGreater(min(self.partners_of_last(run, 2)), 2, "hardly anything was touched")
                    if n > 1:
                        self.assertGreater(run.summary["rebalanced"], 0, "no tile moved: the case is too easy")

    def test_coupled_once_a_sweep(self):
        # The one mode that ranks may be seen in: on one it is the default, on so many ranks two runs have the same bits.
        coupled = sets(stages__push__solver__coupling="sweep")
        default = self.run_scene(FOLD, ranks=1, out="out-default", samples="samples")
        self.assertEqual((default.summary["coupling"], default.summary["rank_independent"]), ("colour", True))
        one = self.run_scene(FOLD, *coupled, ranks=1, out="out-1", samples="samples")
        self.assertNotIn("result holds", one.result.err)
        self.assertEqual((one.hash, one.summary["messages"]), (default.hash, 0))
        series = "series/solver.csv"
        self.assertEqual((one.out / series).read_bytes(), (default.out / series).read_bytes())
        for n in here((2, 3, 5)):
            other = KERNELS[-1 if n == 3 else 0]
            with self.subTest(ranks=n):
                by_colour = self.run_scene(FOLD, ranks=n, out=f"out-default-{n}", samples="samples")
                first, again = (
                    self.run_scene(FOLD, *coupled, "--kernel", k, ranks=n, out=f"out-{n}-{k}-{i}", samples="samples")
                    for i, k in enumerate((KERNELS[-1], other))
                )
                self.assert_same(first, again)
                self.assertEqual((first.summary["coupling"], first.summary["rank_independent"]), ("sweep", False))
                self.assertIn(f"the result holds for {n} ranks", first.result.err)
                self.assertGreater(first.summary["rebalanced"], 0, "no tile moved: the case is too easy")
                self.assertNotEqual(first.hash, one.hash, "no grain is shared: the case is too easy")
                self.assertLess(first.summary["messages"], by_colour.summary["messages"])

    def test_coupled_once_a_sweep_converges(self):
        # Copies that differed, or a change that came twice or not at all, would leave u different from what the impulses
        # give, and no number of sweeps would bring the residual down. Little friction, since with much of it sweeps may
        # cycle.
        keys = sets(stages__push__solver__coupling="sweep", stages__push__solver__tolerance=1e-5)
        keys += sets(stages__push__solver__max_sweeps=20000, laws__0__friction=0.01, laws__1__friction=0.01)
        for n in here((2, 3, 5)):
            with self.subTest(ranks=n):
                run = self.run_scene(FOLD, *keys, "--steps", 5, ranks=n, out=f"out-{n}", samples="samples")
                self.assertLessEqual(run.summary["residual"], 1e-5)

    def test_single_precision(self):
        # Mixed friction, cohesion, and a tolerance, at whose checks impulses go to double and back.
        plain = self.run_scene(FOLD, ranks=1, out="out-plain", samples="samples-plain")
        keys = sets(solver__precision="single", solver__tolerance=0.1, solver__max_sweeps=60)
        keys += sets(laws__0__friction=0.3, laws__0__type="cohesive", laws__0__gamma=2e4, laws__0__d_w=0.02)
        keys += sets(output__measures__during_run="true", output__measures__energy="true")
        for _, run in self.runs(FOLD, (2, 3, 5, 7), *keys):
            self.assertGreater(len(set(run.series("solver")["sweeps"][1:])), 1, "the tolerance never acted")
        for n, run in self.runs(FOLD, (2, 3, 5, 7), *sets(solver__precision="single")):
            self.assertNotEqual(run.hash, plain.hash)

    def test_energy_closes_in_single_precision(self):
        # What u and impulses lost together in float would be seen here: round-off of doubles is all that may be left, of
        # 60 steps, a thousand terms each, relative to the largest column.
        keys = sets(solver__precision="single", output__measures__during_run="true", output__measures__energy="true")
        run = self.run_scene(FOLD, *keys, ranks=1)
        energy = run.series("energy")
        largest = max(abs(v) for column in energy.values() for v in column if v == v)
        self.assertLess(max(abs(v) for v in energy["error"]), 1e-11 * largest)

    def test_sample_made_on_five_ranks_is_used_on_two(self):
        one = self.run_scene(FOLD, ranks=1, out="out-1", samples="samples-1")
        self.run_scene(FOLD, "--steps", "1", "--kernel", KERNELS[0], ranks=5, out="out-5", samples="samples-5")
        for kernel in KERNELS:
            two = self.run_scene(FOLD, "--kernel", kernel, ranks=2, out="out-2", samples="samples-5")
            self.assertTrue(two.summary["sample_reused"])
            self.assert_same(one, two)

    def test_every_instruction_set_alone(self):
        one = self.run_scene(FOLD, "--kernel", "scalar", ranks=1)
        for kernel in KERNELS[1:]:
            with self.subTest(kernel=kernel):
                other = self.run_scene(
                    FOLD, "--kernel", kernel, ranks=1, out=f"out-{kernel}", samples=f"samples-{kernel}"
                )
                self.assertEqual(other.summary["kernel"], kernel)
                self.assert_same(one, other)


if __name__ == "__main__":
    main()
