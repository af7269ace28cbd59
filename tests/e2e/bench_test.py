"""`nappe bench` as its users see it. Figures are asked to be there and to be positive, never to be small: how fast a
shared machine is in a test tells nothing."""

import json
import pathlib
import sys

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parent.parent / "support"))
from nappe_driver import NappeTest, call, main  # noqa: E402

DONE, OTHER, BAD_INPUT = 0, 1, 2


def kernels_of_processor():
    """As the system tells it, in words of its own."""
    flags = set()
    for line in pathlib.Path("/proc/cpuinfo").read_text().splitlines():
        if line.startswith("flags"):
            flags = set(line.split(":")[1].split())
    found = {"portable"}
    found |= {"avx2"} if "avx2" in flags else set()
    found |= {"avx512"} if {"avx512f", "avx512vl"} <= flags else set()
    return found


class Bench(NappeTest):
    def bench(self, *arguments, ranks=0):
        path = self.folder / "bench.json"
        result = call(["bench", "--quick", "--json", path, *arguments], ranks, self.folder)
        self.assertEqual(result.code, DONE, str(result))
        return result, json.loads(path.read_text())

    def check_tables(self, report):
        for table in ("bandwidth", "kernels", "steps", "memory"):
            self.assertGreater(len(report[table]), 0, table)
        for row in report["kernels"]:
            for key in ("ns", "ns_low", "ns_high", "times_reference", "over_fastest", "over_roof", "sweeps_per_round"):
                self.assertGreater(row[key], 0, row)
            self.assertGreaterEqual(row["ns_high"], row["ns_low"])
        measured = {row["kernel"] for row in report["kernels"]}
        self.assertLessEqual(kernels_of_processor() | {"list order"}, measured)
        size = report["bandwidth"][0]
        bytes_moved = 72 + 64 * size["grains"] / size["contacts"]
        self.assertAlmostEqual(size["bytes_per_relaxation"], bytes_moved, places=9)
        self.assertAlmostEqual(size["roof_ns"], bytes_moved / size["triad_best_gb_per_s"], places=9)
        self.assertEqual([row["sweeps"] for row in report["steps"]], [100, 10])
        for row in report["steps"]:
            stages = sum(v for k, v in row.items() if k.endswith("_ms") and k != "step_ms")
            self.assertGreater(row["sweep_ms"], 0)
            self.assertLessEqual(stages, 1.01 * row["step_ms"], "stages overlap")
        self.assertGreater(report["memory"][0]["rebuild_ns_per_grain"], 0)
        self.assertGreater(report["memory"][0]["highest_megabytes"], 1)

    def test_smooth_contacts(self):
        for ranks in (0, 2):
            with self.subTest(ranks=ranks):
                result, report = self.bench("--smooth", ranks=ranks)
                (row,) = report["smooth"]
                # Whole steps: of a contact and of a grain they are the same seconds, up to rounding of the mean count.
                of_step = row["contact_ns"] * row["contacts"] / row["grains"]
                self.assertAlmostEqual(row["grain_ns"] / of_step, 1, delta=0.01)
                self.assertGreater(row["contacts"], row["grains"], "a settled pile has two contacts a grain or so")
                self.assertLessEqual(row["contact_ns_best"], row["contact_ns_low"])
                self.assertEqual("efficiency" in row, ranks == 2)
                self.assertTrue(row.get("same_state", True))
                self.assertNotIn("kernels", report)
                self.assertIn("ns a contact", result.out)

    def test_one_process(self):
        result, report = self.bench()
        self.check_tables(report)
        self.assertEqual(report["machine"]["ranks"], 1)
        self.assertNotIn("exchange", report)
        for text in ("Machine and build", "compiler", "roof ns", "list order", "B/grain"):
            self.assertIn(text, result.out)
        # Arrays of the size of what a sweep moves, in whole lines of 64 bytes.
        size = report["bandwidth"][0]
        moved = 72 * size["contacts"] + 64 * size["grains"]
        self.assertLessEqual(1e6 * size["triad_megabytes"], moved)
        self.assertGreater(1e6 * size["triad_megabytes"], moved - 3 * 64)

    def test_two_ranks(self):
        result, report = self.bench(ranks=2)
        self.check_tables(report)
        self.assertEqual(report["machine"]["ranks"], 2)
        self.assertEqual(len(report["exchange"]), 1)
        self.assertGreater(report["exchange"][0]["exchange_percent"], 0)
        self.assertLess(report["exchange"][0]["imbalance_percent"], 100, "one rank does it all")
        self.assertEqual(result.out.count("Machine and build"), 1, "said by every rank")

    def test_sizes_are_those_asked_for(self):
        _, report = self.bench("--grains", "3000,6000")
        grains = [row["grains"] for row in report["bandwidth"]]
        self.assertEqual(len(grains), 2)
        self.assertEqual(grains[1], 2 * grains[0])
        self.assertAlmostEqual(grains[0], 3000, delta=300)

    def test_pairs_end_in_the_same_state(self):
        _, report = self.bench("--pairs", "3", ranks=2)
        (row,) = report["pairs"]
        self.assertTrue(row["same_state"])
        self.assertEqual(row["pairs"], 3)
        for key in ("one_ns", "all_ns", "speedup", "speedup_low", "speedup_high"):
            self.assertGreater(row[key], 0)
        self.assertNotIn("kernels", report)

    def test_features_tell_what_each_adds(self):
        for ranks in (0, 2):
            _, report = self.bench("--features", ranks=ranks)
            added = {row["feature"]: (row["grain_bytes"], row["contact_bytes"]) for row in report["features"]}
            self.assertEqual(
                added,
                {
                    "friction": (8, 16),
                    "spin without friction": (8, 0),
                    "friction by pair": (0, 8),
                    "cohesion": (0, 9),
                    "restitution": (0, 0),
                    "driven wall": (0, 0),
                    "a cell": (8, 0),
                    "layers": (4, 0),
                },
            )
            for row in report["features"]:
                for key in ("relaxation_ns", "relaxation_ratio", "rest_ns", "rest_ratio"):
                    self.assertGreater(row[key], 0, row)
                    self.assertLess(row[key], 1e6, row)
            variants = {row["feature"]: row["kernel"] for row in report["features"]}
            self.assertEqual(variants["spin without friction"], "frictionless")
            self.assertEqual(variants["friction by pair"], "mixed friction")
            self.assertEqual(variants["cohesion"], "one friction, cohesive")

    def test_bad_input_is_code_2_and_says_the_rule(self):
        bad = [(["--grains", size], f"found '{size}'") for size in ("0", "-5", "many", "2999", "3e3")]
        bad += [(["--features", "--pairs", "3"], "--features")]
        bad += [(["--pairs", "0"], "--pairs"), (["--pairs", "3"], "mpirun"), (["--bananas"], "--bananas")]
        for arguments, named in bad:
            with self.subTest(arguments=arguments):
                result = call(["bench", *arguments], folder=self.folder)
                self.assertEqual(result.code, BAD_INPUT, str(result))
                self.assertIn(named, result.err)
                self.assertEqual(result.out, "")
        result = call(["bench", "--grains", "many"], ranks=2)
        self.assertEqual(result.code, BAD_INPUT, str(result))
        self.assertEqual(result.err.count("found 'many'"), 1)

    def test_file_that_can_not_be_written_is_code_1_before_anything_is_measured(self):
        for ranks in (0, 2):
            result = call(["bench", "--json", self.folder / "missing" / "bench.json"], ranks, self.folder)
            self.assertEqual(result.code, OTHER, str(result))
            self.assertEqual(len(result.errors), 1, result.err)
            self.assertIn("missing", result.errors[0])
            self.assertNotIn("grains", result.out)


if __name__ == "__main__":
    main()
