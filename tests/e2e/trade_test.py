"""`nappe trade` on a tiny scene: its tables on one and two ranks, its resuming, its refusals, its failures."""

import csv
import json
import pathlib
import shutil
import signal
import subprocess
import sys
import time

import numpy as np
from matplotlib.image import imread

ROOT = pathlib.Path(__file__).resolve().parents[2]
sys.path[:0] = [str(ROOT / "tests/support"), str(ROOT / "tools")]
from nappe_plot import palette, trade  # noqa: E402
from nappe_driver import SCENES, NappeTest, call, finish, main, sets, start  # noqa: E402

FOLD = SCENES / "small_fold.toml"
DONE, BAD_INPUT, STOPPED = 0, 2, 3
MATRIX = """seeds = [3, 4]
window = 0.5
[reference]
solver = { substeps = 3, sweeps = 150 }
[[settings]]
name = "coarse"
solver = { sweeps = 4 }
[[settings]]
name = "fine"
solver = { h = 0.0125, sweeps = 20 }
"""
NAMES = ["reference", "coarse", "fine"]
# What a rank more changes: clocks, messages, and what is made of them.
OF_THE_MACHINE = {
    "seconds_loading", "seconds_steps", "seconds_sweeping", "ns_per_relaxation", "messages", "message_bytes",
    "front_seconds",
}  # fmt: skip


def rows_of(path):
    with open(path, newline="") as file:
        return list(csv.DictReader(file))


class Trade(NappeTest):
    def arguments(self, *more, matrix=MATRIX, out="trade"):
        file = self.folder / "matrix.toml"
        file.write_text(matrix)
        folders = ["--out", self.folder / out, "--samples", self.folder / "samples"]
        return ["trade", FOLD, "--matrix", file, *folders, *more]

    def trade(self, *more, ranks=0, code=DONE, matrix=MATRIX, out="trade"):
        result = call(self.arguments(*more, matrix=matrix, out=out), ranks, self.folder)
        self.assertEqual(result.code, code, str(result))
        return result

    def table(self, out="trade", name="trade"):
        return rows_of(self.folder / out / f"{name}.csv")

    def summaries(self, out="trade"):
        paths = sorted((self.folder / out / "runs").glob("*/seed-*/summary.json"))
        return {str(path.parent.relative_to(self.folder / out / "runs")): path for path in paths}

    def without_clocks(self, out):
        return [{k: v for k, v in row.items() if k not in OF_THE_MACHINE} for row in self.table(out)]

    def test_tables_are_the_same_on_one_and_two_ranks(self):
        one, two = self.trade(), self.trade(ranks=2, out="trade-2")
        self.assertEqual(sorted(self.summaries()), sorted(f"{n}/seed-{s}" for n in NAMES for s in (3, 4)))
        for out in ("trade", "trade-2"):
            rows = self.table(out)
            self.assertEqual([row["setting"] for row in rows], NAMES)
            self.assertEqual({row["status"] for row in rows}, {"done"})
        self.assertEqual(*(self.without_clocks(out) for out in ("trade", "trade-2")))
        self.assertEqual(*((self.folder / out / "observables.csv").read_text() for out in ("trade", "trade-2")))
        self.assertGreater(float(self.table("trade-2")[1]["messages"]), 0)
        for result in (one, two):
            self.assertEqual(result.out.count("\ncoarse "), 1, result.out)  # printed once, by one rank
            self.assertEqual(len([line for line in result.err.splitlines() if "relaxations in" in line]), 6, result.err)

    def check_against_the_runs(self):
        """The figures of the table, from the files of the runs by hand."""
        known = {(r["setting"], r["observable"]): r for r in self.table(name="observables")}
        for row in self.table():
            runs = [json.loads(self.summaries()[f"{row['setting']}/seed-{s}"].read_text()) for s in (3, 4)]
            self.assertEqual(float(row["relaxations"]), sum(r["relaxations"] for r in runs) / 2)
            largest = []
            # Half of 1.5 s is the window, with rows every 0.25 s whatever the step: the last three.
            p, carried = [], []
            for seed, run in zip((3, 4), runs):
                series = self.folder / "trade/runs" / row["setting"] / f"seed-{seed}" / "series"
                rows = rows_of(series / "solver.csv")
                largest += [float(r["overlap_max"]) for r in rows[1:]]  # the first is of the sample
                rows = rows_of(series / "cell-W1.csv")
                self.assertEqual([float(r["time"]) for r in rows], [0.25 * k for k in range(7)])
                p.append(sum(float(r["p"]) for r in rows[4:]) / 3)
                walls = [rows_of(series / f"wall-{w}.csv") for w in ("floor", "piston", "right")]
                down = [-sum(float(w[k]["fy"]) for w in walls) for k in range(4, 7)]
                carried.append(sum(down) / 3 / (run["mass"] * 9.81))
            self.assertEqual(float(row["overlap_max_of_rows"]), max(largest))
            self.assertAlmostEqual(float(known[row["setting"], "W1.p"]["mean"]) / (sum(p) / 2), 1, 12)
            self.assertAlmostEqual(float(row["weight_on_walls"]), sum(carried) / 2, 12)
            self.assertLess(float(row["energy_closure"]), 1e-12)  # round-off, over the work done
            self.assertLessEqual(float(row["weight_on_walls_least"]), float(row["weight_on_walls"]))

    def test_figures_are_those_of_the_runs(self):
        self.trade()
        self.check_against_the_runs()
        folders = [path.parent for path in self.summaries().values()]
        starts = {(folder.name, rows_of(folder / "series/solver.csv")[0]["overlap_mean"]) for folder in folders}
        self.assertEqual(len(starts), 2, "settings of a seed do not start from one sample")
        reference = [r for r in self.table(name="observables") if r["setting"] == "reference"]
        self.assertEqual({r["difference"] for r in reference}, {"0"})

    def test_a_stopped_matrix_goes_on_without_running_finished_runs_again(self):
        self.trade(out="whole")
        shutil.rmtree(self.folder / "samples")
        # So long that the signal comes in time: after the first run, within one of the next.
        longer = sets(stages__push__duration=30, walls__piston__motion__velocity="[0.05, 0]")
        process = start(self.arguments(*longer, out="long"), 0, self.folder)
        deadline = time.monotonic() + 200
        while not self.summaries("long") and process.poll() is None and time.monotonic() < deadline:
            time.sleep(0.02)
        process.send_signal(signal.SIGUSR1)
        result = finish(process)
        self.assertEqual(result.code, STOPPED, str(result))
        self.assertIn("the same command again", result.out)
        stopped = {n: json.loads(path.read_text())["stopped_early"] for n, path in self.summaries("long").items()}
        done = [name for name, early in stopped.items() if not early]
        self.assertIn("reference/seed-3", done)
        self.assertLess(len(done), 6, "nothing was left to do")
        self.assertNotEqual({row["status"] for row in self.table("long")}, {"done"})

        # Cut short at another place: three runs of the whole matrix are gone, one of them half written.
        gone = ["fine/seed-3", "reference/seed-4", "coarse/seed-4"]
        before = {name: path.stat().st_mtime_ns for name, path in self.summaries("whole").items() if name not in gone}
        expected = (self.folder / "whole/observables.csv").read_text()
        for name in gone[:2]:
            shutil.rmtree(self.folder / "whole/runs" / name)
        self.summaries("whole")["coarse/seed-4"].unlink()
        result = self.trade(out="whole")
        self.assertIn("3 of 6 runs are done", result.err)
        self.assertEqual(len([line for line in result.err.splitlines() if "relaxations in" in line]), 3, result.err)
        after = {name: path.stat().st_mtime_ns for name, path in self.summaries("whole").items()}
        self.assertEqual({name: after[name] for name in before}, before, "a finished run was run again")
        self.assertEqual((self.folder / "whole/observables.csv").read_text(), expected)

    def test_a_finished_run_of_another_scene_is_refused_before_anything_is_run(self):
        self.trade("--seeds", "1", matrix=MATRIX)
        before = {path: path.stat().st_mtime_ns for path in self.folder.rglob("*") if path.is_file()}
        for ranks in (0, 2):
            result = self.trade("--seeds", "2", *sets(solver__theta=0.7), ranks=ranks, code=BAD_INPUT)
            self.assertEqual(len(result.errors), 1, result.err)
            self.assertIn("runs/reference/seed-1: must be of this scene", result.err)
        before.pop(self.folder / "matrix.toml")
        self.assertEqual({path: path.stat().st_mtime_ns for path in before}, before)

    def test_bad_matrices_are_refused_with_file_and_line(self):
        for old, new, said in (
            ("window", "windw", "matrix.toml:2: windw: unknown key"),
            ("sweeps = 4", "sweps = 4", "matrix.toml:7: settings.coarse: stages.push.solver.sweps: unknown key"),
            ("h = 0.0125", "h = 0", "matrix.toml:10: settings.fine: stages.push.solver.h: must be > 0"),
        ):
            for ranks in (0, 2):
                with self.subTest(said=said, ranks=ranks):
                    result = self.trade(matrix=MATRIX.replace(old, new), ranks=ranks, code=BAD_INPUT)
                    self.assertEqual(len(result.errors), 1, result.err)
                    self.assertIn(said, result.err)
                    self.assertFalse((self.folder / "trade").exists())
        result = call(["trade", FOLD, "--matrix", self.folder / "none.toml"], folder=self.folder)
        self.assertEqual(result.code, BAD_INPUT)
        self.assertIn("none.toml: must be a readable matrix file", result.err)

    def test_a_run_that_fails_is_a_row_and_not_the_end(self):
        # At this step the piston alone outruns the tiles' margin.
        fast = MATRIX.replace("h = 0.0125, sweeps = 20", "h = 0.75, sweeps = 1")
        for ranks in (0, 2):
            out = f"trade-{ranks}"
            result = self.trade(matrix=fast, ranks=ranks, out=out)
            rows = {row["setting"]: row for row in self.table(out)}
            self.assertIn("failed (2 of 2): ", rows["fine"]["status"])
            self.assertIn("fine: failed (2 of 2): ", result.out)
            self.assertEqual((rows["fine"]["front_relaxations"], rows["coarse"]["status"]), ("-", "done"))
            again = self.trade(matrix=fast, ranks=ranks, out=out)
            self.assertIn("6 of 6 runs are done", again.err)
        reason = json.loads((self.folder / "trade-0/runs/fine/seed-3/failed.json").read_text())["reason"]
        self.assertIn(reason, rows["fine"]["status"])

    def test_one_seed_knows_no_scatter(self):
        result = self.trade("--seeds", "1")
        self.assertIn("no scatter is known", result.out)
        verdicts = {row["verdict"] for row in self.table(name="observables")}
        self.assertLessEqual(verdicts, {"no scatter known", "not measured"})
        self.assertEqual([row["observable_error"] for row in self.table()], ["nan"] * 3)

    def test_columns_are_those_of_the_documentation(self):
        self.trade("--seeds", "1")
        text = (pathlib.Path(__file__).parents[2] / "docs/accuracy.md").read_text()

        def documented(section):
            rows = text.split(f"### {section}\n")[1].split("\n### ")[0].splitlines()
            cells = [row.split("|")[1] for row in rows if row.startswith("| `")]
            return [name.strip(" `") for cell in cells for name in cell.split(",")]

        self.assertEqual(list(self.table()[0]), ["setting", "seeds", *documented("What is measured")])
        self.assertEqual(list(self.table(name="observables")[0]), ["setting", *documented("Observables")])

    def test_pictures_show_settings_and_their_front(self):
        self.trade()
        pictures = self.folder / "trade/pictures"
        plot = [ROOT / "tools/plot", self.folder / "trade"]
        drawn = subprocess.run(plot, stdout=subprocess.PIPE, text=True, check=True)
        names = [f"trade-{cost}.png" for cost in ("relaxations", "seconds")]
        self.assertEqual(drawn.stdout.split(), [str((pictures / name).resolve()) for name in names])
        for name in names:
            picture = imread(pictures / name)[..., :3]
            for colour in (trade.REFERENCE, trade.FRONT):
                near = abs(picture - np.array(palette.rgb(colour))).max(axis=-1) < 0.05
                self.assertGreater(near.sum(), 500, f"{name} shows nothing in {colour}")
        # The front of a panel is the one that the table marks.
        rows = trade.read(self.folder / "trade")["settings"]
        for cost, key in (("relaxations", "relaxations"), ("seconds", "seconds_steps")):
            on_front = {k + 1 for k in trade.front([r[key] for r in rows[1:]], [r["overlap_mean"] for r in rows[1:]])}
            self.assertEqual(on_front, {k for k, row in enumerate(rows) if row["front"][f"{cost}_overlap"]})
        self.assertEqual(trade.front([1, 2, 3, 2, np.nan], [5, 5, 1, 4, 0]), [0, 3, 2])

    def test_a_folder_that_is_no_table_is_refused(self):
        (self.folder / "trade.json").write_text('{"settings": 3}')
        result = subprocess.run([ROOT / "tools/plot", self.folder], stderr=subprocess.PIPE, text=True)
        self.assertEqual(result.returncode, 1)
        self.assertIn("trade.json is not a table of nappe trade", result.stderr)


if __name__ == "__main__":
    main()
