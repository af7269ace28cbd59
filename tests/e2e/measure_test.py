"""`nappe measure DIR`: the same files as the run itself leaves, on any number of ranks; against what frames and series
say; and its errors."""

import csv
import math
import pathlib
import shutil
import sys

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parent.parent / "support"))
from nappe_driver import SCENES, WALL_KEY, NappeTest, Run, call, main, sets  # noqa: E402

import h5py  # noqa: E402
import numpy as np  # noqa: E402

FOLD = SCENES / "small_fold.toml"
DONE, OTHER, BAD_INPUT = 0, 1, 2
MEASURED = ["measures/cell-W1.csv", "measures/cell-W2.csv", "measures/whole.csv"]


class Measure(NappeTest):
    """One run that measured itself, and what `nappe measure` makes of its frames."""

    @classmethod
    def setUpClass(cls):
        super().setUpClass()
        out, samples = cls.class_folder / "out", cls.class_folder / "samples"
        keys = sets(output__series__every=1, output__frames__every=20, output__measures__during_run="true",
                    output__measures__energy="true", stages__push__solver__substeps=2)
        result = call(["run", FOLD, "--out", out, "--samples", samples, *keys], ranks=2)
        assert result.code == DONE, str(result)
        cls.fold = Run(out, result)

    def measured(self, folder, name):
        """Column name -> array over frames."""
        with open(folder / f"{name}.csv", newline="") as file:
            rows = list(csv.reader(file))
        return dict(zip(rows[0], np.array(rows[1:], dtype=float).T))

    def copy_of_run(self):
        copy = self.folder / "copy"
        shutil.copytree(self.fold.out, copy)
        shutil.rmtree(copy / "measures")
        return copy

    def assert_same_as_in_the_run(self, folder):
        ours = {p.relative_to(folder): p.read_bytes() for p in folder.rglob("*") if p.is_file()}
        run = self.fold.out / "measures"
        theirs = {p.relative_to(run): p.read_bytes() for p in run.rglob("*") if p.is_file()}
        self.assertEqual(sorted(ours), sorted(theirs))
        for name, content in theirs.items():
            self.assertEqual(ours[name], content, name)

    def test_run_leaves_its_measures(self):
        for name in MEASURED:
            self.assertIn(name, self.fold.files())

    def test_any_number_of_ranks_gives_the_files_of_the_run(self):
        for ranks in (0, 1, 2, 3):
            with self.subTest(ranks=ranks):
                out = self.folder / f"on-{ranks}"
                result = call(["measure", self.fold.out, "--out", out], ranks=ranks)
                self.assertEqual(result.code, DONE, str(result))
                self.assert_same_as_in_the_run(out)

    def test_measures_lie_beside_the_frames(self):
        copy = self.copy_of_run()
        self.assertEqual(call(["measure", copy]).code, DONE)
        self.assert_same_as_in_the_run(copy / "measures")

    def test_unfinished_runs_and_runs_of_older_versions(self):
        copy = self.copy_of_run()
        (copy / "summary.json").rename(self.folder / "summary.json")  # as if killed
        self.assertEqual(call(["measure", copy]).code, DONE)
        self.assert_same_as_in_the_run(copy / "measures")
        (copy / "scene.toml").unlink()
        shutil.copy(self.folder / "summary.json", copy)
        self.assertEqual(call(["measure", copy]).code, DONE)
        self.assert_same_as_in_the_run(copy / "measures")

    def test_frames_of_an_older_run_do_not_count(self):
        copy = self.copy_of_run()
        shutil.copy(copy / "frames/frame-00000020.hdf", copy / "frames/frame-00000030.hdf")
        self.assertEqual(call(["measure", copy]).code, DONE)
        self.assert_same_as_in_the_run(copy / "measures")

    def test_a_run_takes_away_measures_of_an_older_one(self):
        out, samples = self.folder / "out", self.folder / "samples"
        measuring = sets(output__measures__during_run="true")
        self.assertEqual(call(["run", FOLD, "--out", out, "--samples", samples, "--steps", 1, *measuring]).code, DONE)
        self.assertTrue((out / "measures/whole.csv").exists())
        self.assertEqual(call(["run", FOLD, "--out", out, "--samples", samples, "--steps", 1, "--overwrite"]).code, DONE)
        self.assertFalse((out / "measures/whole.csv").exists())

    def test_scene_as_run_is_that_of_the_summary(self):
        self.assertEqual((self.fold.out / "scene.toml").read_text(), self.fold.summary["scene"])

    def test_what_series_have_too_is_the_same(self):
        for cell in ("W1", "W2"):
            measured = self.measured(self.fold.out / "measures", f"cell-{cell}")
            series = self.fold.series(f"cell-{cell}")
            np.testing.assert_array_equal(measured["step"], [0, 20, 40, 60])
            for k, step in enumerate((0, 20, 40, 60)):
                at = series["step"].index(step)
                for column in ("time", "lambda_x", "lambda_y", "grains"):
                    self.assertEqual(measured[column][k], series[column][at], f"{column} of {cell} at {step}")
                if step == 0:  # later, series are means over the two substeps, and normals have turned a little
                    for column in ("p", "q"):
                        self.assertAlmostEqual(measured[column][k] / series[column][at], 1, delta=1e-11)

    def test_whole_sample_against_its_frames(self):
        measured = self.measured(self.fold.out / "measures", "whole")
        h = 0.025 / 2
        volume = None
        for k, step in enumerate((0, 20, 40, 60)):
            with h5py.File(self.fold.out / f"frames/frame-{step:08}.hdf") as frame:
                radius = frame["VTKHDF/PointData/radius"][()]
                x = frame["VTKHDF/Points"][()][:, :2]
                lo, hi = frame["contacts/lo"][()], frame["contacts/hi"][()]
                n = frame["contacts/normal"][()][:, :2]
                r_n, gap = frame["contacts/r_n"][()], frame["contacts/gap"][()]
            w = 8 * radius.mean()
            s = np.linalg.norm(x[:, None] - x[None, :], axis=2) / w
            kernel = np.where(s < 1, 5 / (math.pi * w**2) * (1 + 3 * s) * (1 - np.minimum(s, 1)) ** 3, 0)
            area = math.pi * radius**2
            fraction = area.sum() / (area / (kernel @ area)).sum()
            volume = area.sum() / fraction if volume is None else volume
            pairs = hi < WALL_KEY
            arm = radius[lo] + np.where(pairs, radius[np.where(pairs, hi, 0)], 0)
            acting = r_n != 0
            number = np.bincount(lo[acting], minlength=len(x)) + np.bincount(hi[pairs & acting], minlength=len(x))
            f1, f2 = np.linalg.eigvalsh(n[acting].T @ n[acting])[::-1]
            smaller = np.minimum(radius[lo], np.where(pairs, radius[np.where(pairs, hi, 0)], np.inf))
            overlap = np.maximum(-gap, 0) / smaller
            expected = {
                "p": (r_n * arm).sum() / (2 * h * volume), "solid_fraction": fraction, "grains": len(x),
                "coordination": number.mean(), "fabric_1": f1 / volume, "fabric_2": f2 / volume,
                "anisotropy": (f1 - f2) / (2 * volume), "anisotropy_normalised": (f1 - f2) / (2 * acting.sum()),
                "overlap_mean": overlap[acting].mean(), "overlap_max": overlap.max(),
            }  # fmt: skip
            for column, value in expected.items():
                np.testing.assert_allclose(measured[column][k], value, rtol=1e-9, err_msg=f"{column} at step {step}")

    def test_blocks_of_a_cohesive_fault(self):
        # Intact bonds and the blocks that they leave, from the frames by plain sets.
        keys = sets(output__measures__during_run="true", output__measures__energy="true")
        out = self.folder / "fault"
        result = call(["run", SCENES / "small_fault.toml", "--out", out, "--samples", self.folder / "s", *keys], ranks=3)
        self.assertEqual(result.code, DONE, str(result))
        again = self.folder / "again"
        self.assertEqual(call(["measure", out, "--out", again], ranks=2).code, DONE)
        for path in (out / "measures").rglob("*.csv"):
            self.assertEqual((again / path.name).read_bytes(), path.read_bytes(), path.name)
        blocks, first = self.measured(again, "blocks"), None
        for row, step in enumerate(blocks["step"].astype(int)):
            with h5py.File(out / f"frames/frame-{step:08}.hdf") as file:
                n = len(file["VTKHDF/Points"])
                pairs = zip(*(file[f"contacts/{name}"][()] for name in ("lo", "hi", "bond")))
                bonds = {(lo, hi) for lo, hi, bond in pairs if bond and hi < n}
            first = first or bonds
            block_of = {i: {i} for i in range(n)}
            for lo, hi in bonds & first:
                if block_of[lo] is not block_of[hi]:
                    block_of[lo] |= block_of[hi]
                    block_of.update({i: block_of[lo] for i in block_of[hi]})
            sizes = sorted(len(block) for block in {id(block): block for block in block_of.values()}.values())
            others = [size for size in sizes[:-1] if size > 1]
            self.assertEqual(blocks["intact"][row], len(bonds & first) / len(first))
            self.assertEqual(blocks["largest"][row], sizes[-1])
            self.assertEqual((blocks["detached"][row], blocks["detached_grains"][row]), (len(others), sum(others)))
            self.assertEqual(blocks["single"][row], sizes.count(1))
        self.assertGreater(blocks["detached"][-1], 0, "nothing came off: the case is too easy")

    def test_energy_closes(self):
        energy = self.fold.series("energy")
        self.assertEqual(list(energy)[2:], ["kinetic", "potential", "wall_work", "gravity", "friction", "impact",
                                            "cohesion", "theta_term", "error"])  # fmt: skip
        work = max(np.abs(energy[column]).max() for column in ("wall_work", "gravity", "friction", "impact"))
        self.assertGreater(work, 1e3)
        self.assertLess(np.abs(energy["error"]).max(), 1e-12 * work)
        lost = np.array(energy["potential"][0]) - energy["potential"]
        np.testing.assert_allclose(energy["gravity"], lost, rtol=0, atol=1e-10 * work)

    def test_setting_keys(self):
        out = self.folder / "wide"
        self.assertEqual(call(["measure", self.fold.out, "--out", out, *sets(output__measures__range=9)]).code, DONE)
        wide, plain = (self.measured(f, "whole")["solid_fraction"] for f in (out, self.fold.out / "measures"))
        self.assertTrue((wide < plain).all(), "a kernel that reaches farther over the border finds less")

    def errors(self):
        """What is wrong, and what the message must name."""
        empty, broken, cut, first = (self.folder / name for name in ("empty", "broken", "cut", "first"))
        empty.mkdir()
        for copy in (broken, cut, first):
            shutil.copytree(self.fold.out, copy)
        (broken / "scene.toml").write_text("[world\n")
        (cut / "frames/frame-00000040.hdf").write_bytes(b"not HDF5")
        index = (first / "run.xdmf").read_text()
        (first / "run.xdmf").write_text(index.replace("frame-00000000", "gone"))
        return [
            (["measure"], "run is required"),
            (["measure", self.folder / "missing"], "scene.toml"),
            (["measure", empty], "scene.toml"),
            (["measure", broken], "scene.toml:1"),
            (["measure", cut], "frame-00000040.hdf"),
            (["measure", first], "step 0"),
            (["measure", self.fold.out, *sets(solver__h=1)], "solver.h"),
            (["measure", self.fold.out, "--bananas"], "--bananas"),
        ]

    def test_bad_input_is_code_2_and_said_once(self):
        for arguments, named in self.errors():
            for ranks in (0, 2):
                with self.subTest(arguments=[str(a) for a in arguments], ranks=ranks):
                    result = call([*arguments, *(["--out", self.folder / "out"] if len(arguments) > 1 else [])], ranks)
                    self.assertEqual(result.code, BAD_INPUT, str(result))
                    said = [line for line in result.err.splitlines() if named in line]
                    self.assertEqual(len(said), 1, result.err)

    def test_folder_that_can_not_be_made_is_code_1(self):
        (self.folder / "file").write_text("not a folder")
        for ranks in (0, 2):
            result = call(["measure", self.fold.out, "--out", self.folder / "file/out"], ranks)
            self.assertEqual(result.code, OTHER, str(result))
            self.assertEqual(len(result.errors), 1, result.err)
            self.assertIn("file/out", result.errors[0])


if __name__ == "__main__":
    main()
