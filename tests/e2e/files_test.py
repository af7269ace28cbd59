"""The files that `nappe run` leaves: complete, as documented, and with numbers that agree with each other."""

import math
import pathlib
import re
import sys

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parent.parent / "support"))
from nappe_driver import SCENES, WALL_KEY, NappeTest, Run, call, main, sets  # noqa: E402

import h5py  # noqa: E402
import numpy as np  # noqa: E402

FOLD = SCENES / "small_fold.toml"
DONE = 0


class Files(NappeTest):
    """One run with a row of every step; its files against each other."""

    @classmethod
    def setUpClass(cls):
        super().setUpClass()
        out, samples = cls.class_folder / "out", cls.class_folder / "samples"
        result = call(["run", FOLD, "--out", out, "--samples", samples, *sets(output__series__every=1)], ranks=2)
        assert result.code == DONE, str(result)
        cls.fold = Run(out, result)
        cls.radius_of_cell = {"W1": 2.5, "W2": 2.0}

    def frames(self):
        for path in sorted((self.fold.out / "frames").iterdir()):
            with h5py.File(path) as file:
                yield int(file.attrs["step"]), file

    def row(self, name, step):
        series = self.fold.series(name)
        at = series["step"].index(step)
        return {column: values[at] for column, values in series.items()}

    def assert_near(self, found, expected, message, digits=11):
        """Equal but for the order of a sum's terms."""
        scale = np.max(np.abs(expected)) or 1.0
        np.testing.assert_allclose(found, expected, rtol=10.0**-digits, atol=scale * 10.0**-digits, err_msg=message)

    def test_names(self):
        series = ["cell-W1", "cell-W2", "energy", "front", "solver", "wall-floor", "wall-piston", "wall-right"]
        frames = [f"frames/frame-{step:08}.hdf" for step in (0, 30, 60)]
        others = ["contacts.xdmf", "run.xdmf", "scene.toml", "summary.json"]
        self.assertEqual(self.fold.files(), sorted([*others, *frames, *(f"series/{s}.csv" for s in series)]))

    def test_summary_has_what_scripts_rely_on(self):
        summary = self.fold.summary
        kinds = {
            "version": str, "scene": str, "ranks": int, "grains": int, "contacts": int, "steps": int,
            "time_simulated": float, "relaxations": int, "seconds_total": float, "seconds": dict,
            "ns_per_relaxation": float, "overlap_mean": float, "overlap_max": float, "residual": float,
            "bytes_per_grain": int, "bytes_per_contact": int, "state_hash": str, "stopped_early": bool,
        }  # fmt: skip
        for key, kind in kinds.items():
            self.assertIsInstance(summary.get(key), kind, key)
        self.assertRegex(summary["state_hash"], r"^[0-9a-f]{16}$")
        self.assertEqual((summary["ranks"], summary["steps"]), (2, 60))
        self.assertAlmostEqual(summary["time_simulated"], 1.5)
        self.assertGreater(summary["ns_per_relaxation"], 0)
        self.assertGreater(summary["residual"], 0)
        for stage, seconds in summary["seconds"].items():
            self.assertGreaterEqual(seconds, 0, stage)
        self.assertLess(max(summary["seconds"].values()), summary["seconds_total"])
        last = self.row("solver", 60)
        for key, column in (("overlap_mean",) * 2, ("overlap_max",) * 2, ("residual",) * 2, ("contacts",) * 2):
            self.assertEqual(summary[key], last[column], key)
        self.assertEqual(summary["overlap_max_of_rows"], max(self.fold.series("solver")["overlap_max"]))
        self.assertEqual(summary["residual_max_of_rows"], max(self.fold.series("solver")["residual"][1:]))
        self.assertEqual(summary["sweeps"], 60 * 10)

    def documented(self, section, file=None):
        """Names in backticks in a table of docs/output.md: of the row of a file, or of the first column."""
        text = (pathlib.Path(__file__).parents[2] / "docs/output.md").read_text()
        lines = text.split(f"## {section}\n")[1].split("\n## ")[0].splitlines()
        rows = [line.split("|") for line in lines if "|" in line]
        cells = [row[2] for row in rows if f"`{file}`" in row[1]] if file else [row[1] for row in rows]
        return re.findall("`([^`]+)`", " ".join(cells))

    def test_summary_is_what_the_documentation_says(self):
        self.assertEqual(sorted(self.fold.summary), sorted(self.documented("Summary")))

    def test_series_have_their_columns_and_a_row_for_every_step(self):
        columns = {
            "cell-W1": ["p", "q", "lambda_x", "lambda_y", "grains"],
            "wall-piston": ["x", "y", "vx", "vy", "fx", "fy"],
            "front": ["front"],
            "energy": ["kinetic", "potential", "wall_work"],
            "solver": ["residual", "residual_rms", "sweeps", "overlap_mean", "overlap_max", "contacts", "candidates",
                       "rebuilds", "redone"],
        }  # fmt: skip
        for name, wanted in columns.items():
            self.assertEqual(self.documented("Series", re.sub("-.*", "-NAME", name) + ".csv"), wanted, name)
            series = self.fold.series(name)
            self.assertEqual(list(series), ["step", "time", *wanted], name)
            self.assertEqual(series["step"], list(range(61)), name)
            self.assert_near(series["time"], 0.025 * np.arange(61), name)

    def test_walls_are_where_the_series_say(self):
        for step, frame in self.frames():
            moved = frame["walls/piston"][()] - [[0, 20, 0], [0, 0, 0]]
            row = self.row("wall-piston", step)
            self.assertEqual((row["x"], row["y"]), (moved[0, 0], 0.0))
            self.assertAlmostEqual(row["x"], 1.0 * 0.025 * step, delta=1.0 * 0.025)  # theta-scheme: half a step late
            self.assertEqual(moved[0, 0], moved[1, 0])
            self.assertEqual(self.row("wall-floor", step)["y"], 0.0)

    def contacts(self, frame):
        lo, hi = frame["contacts/lo"][()], frame["contacts/hi"][()]
        normal = frame["contacts/normal"][()][:, :2]
        tangent = np.stack([-normal[:, 1], normal[:, 0]], axis=1)
        r_n, r_t = frame["contacts/r_n"][()], frame["contacts/r_t"][()].reshape(-1)
        return lo, hi, r_n, r_n[:, None] * normal + r_t[:, None] * tangent, normal

    def test_stress_of_cells(self):
        for step, frame in self.frames():
            lo, hi, r_n, r, normal = self.contacts(frame)
            radius = frame["VTKHDF/PointData/radius"][()]
            cells = frame["VTKHDF/PointData/cells"][()]
            of_grains = hi < WALL_KEY
            for bit, (name, circle) in enumerate(self.radius_of_cell.items()):
                member = (cells >> np.uint64(bit)) & np.uint64(1) == 1
                row = self.row(f"cell-{name}", step)
                self.assertEqual(row["grains"], np.count_nonzero(member))
                self.assertGreater(row["grains"], 5)
                arm = np.where(member[lo], radius[lo], 0.0)
                arm[of_grains] += np.where(member[hi[of_grains]], radius[hi[of_grains]], 0.0)
                volume = math.pi * circle**2  # the grains' own over their share of the circle when loading starts
                self.assert_near(row["p"], np.sum(r_n * arm) / (2 * 0.025 * volume), f"p of {name} at step {step}")
                if step == 0:  # later, normals have turned a little since the step found its forces
                    sigma = np.einsum("c,ci,cj->ij", arm, r, normal) / (0.025 * volume)
                    s1, s2 = np.linalg.eigvalsh((sigma + sigma.T) / 2)
                    self.assert_near(row["q"], (s2 - s1) / 2, f"q of {name}", digits=9)

    def test_shape_of_cells(self):
        first = None
        for step, frame in self.frames():
            x = frame["VTKHDF/Points"][()][:, :2]
            member = frame["VTKHDF/PointData/cells"][()] & np.uint64(1) == 1
            extent = x[member].max(axis=0) - x[member].min(axis=0)
            first = extent if first is None else first
            row = self.row("cell-W1", step)
            self.assert_near([row["lambda_x"], row["lambda_y"]], extent / first, f"step {step}")
            if step == 0:
                inside = np.hypot(x[:, 0] - 10, x[:, 1] - 3) <= 2.5
                np.testing.assert_array_equal(member, inside)

    def test_forces_on_walls(self):
        for step, frame in self.frames():
            _, _, _, r, _ = self.contacts(frame)
            wall = frame["contacts/wall"][()]
            for index, name in enumerate(("floor", "piston", "right")):
                force = -np.sum(r[wall == index], axis=0) / 0.025
                row = self.row(f"wall-{name}", step)
                self.assert_near([row["fx"], row["fy"]], force, f"{name} at step {step}", digits=9)
            mass = frame["VTKHDF/PointData/mass"][()].sum()
            if step == 0:
                # Settled loosely.
                self.assertAlmostEqual(self.row("wall-floor", 0)["fy"] / (-9.81 * mass), 1, delta=0.1)

    def test_energies_overlaps_and_loads_of_grains(self):
        for step, frame in self.frames():
            data = frame["VTKHDF/PointData"]
            mass, radius = data["mass"][()], data["radius"][()]
            v, spin = data["velocity"][()], data["spin"][()].reshape(-1)
            x = frame["VTKHDF/Points"][()]
            energy = self.row("energy", step)
            kinetic = 0.5 * mass * (v**2).sum(axis=1) + 0.25 * mass * (radius * spin) ** 2
            self.assert_near(energy["kinetic"], kinetic.sum(), f"step {step}")
            self.assert_near(energy["potential"], (mass * 9.81 * x[:, 1]).sum(), f"step {step}")

            lo, hi, r_n, _, _ = self.contacts(frame)
            gap = frame["contacts/gap"][()]
            pairs = hi < WALL_KEY
            smaller = radius[lo].copy()
            smaller[pairs] = np.minimum(smaller[pairs], radius[hi[pairs]])
            overlap = np.maximum(-gap, 0) / smaller
            solver = self.row("solver", step)
            self.assertEqual(solver["overlap_max"], overlap.max())
            self.assertEqual(solver["contacts"], np.count_nonzero(r_n > 0))
            self.assert_near(solver["overlap_mean"], overlap[r_n > 0].mean(), f"step {step}")

            load = np.bincount(lo, r_n, len(mass)) + np.bincount(hi[pairs], r_n[pairs], len(mass))
            self.assert_near(data["pressure"][()], load / 0.025 / (2 * math.pi * radius), f"step {step}")
            acting = r_n > 0
            number = np.bincount(lo[acting], minlength=len(mass))
            number += np.bincount(hi[pairs & acting], minlength=len(mass))
            np.testing.assert_array_equal(data["coordination"][()], number)

    def test_mass_is_that_of_disks_and_nothing_is_lost(self):
        masses = []
        for _, frame in self.frames():
            data = frame["VTKHDF/PointData"]
            np.testing.assert_array_equal(data["id"][()], np.arange(self.fold.summary["grains"]))
            np.testing.assert_allclose(data["mass"][()], 2800 * math.pi * data["radius"][()] ** 2, rtol=1e-14)
            masses.append(data["mass"][()].tobytes())
        self.assertEqual(len(set(masses)), 1)

    def test_friction_limits_every_contact_and_status_says_so(self):
        for step, frame in self.frames():
            r_n, r_t = frame["contacts/r_n"][()], frame["contacts/r_t"][()].reshape(-1)
            status = frame["contacts/status"][()]
            self.assertGreaterEqual(r_n.min(), 0)
            # A contact's limit follows its own last r_n: exact but for the rounding of the product.
            self.assertLessEqual(np.max(np.abs(r_t) - 0.4 * r_n * (1 + 1e-15)), 0, f"step {step}")
            wanted = np.where(r_n <= 0, 0, np.where(np.abs(r_t) < 0.4 * r_n * (1 - 1e-12), 1, 2))
            np.testing.assert_array_equal(status, wanted)

    def test_log_that_is_no_terminal_has_plain_lines(self):
        self.assertNotIn("\r", self.fold.result.err)
        self.assertNotIn("\x1b", self.fold.result.err)
        self.assertIn(self.fold.hash, self.fold.result.err + self.fold.result.out)


if __name__ == "__main__":
    main()
