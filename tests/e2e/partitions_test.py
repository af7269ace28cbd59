"""`nappe partitions` as its users see it, and tools/scaling_model on what it wrote. Called like run_test.py; the
model's formulas are held against cuts worked out by hand."""

import json
import pathlib
import sys
import unittest

ROOT = pathlib.Path(__file__).resolve().parents[2]
sys.path[:0] = [str(ROOT / "tests" / "support"), str(ROOT / "tools")]
from nappe_driver import SCENES, NappeTest, call, main, sets  # noqa: E402

import numpy as np  # noqa: E402
from nappe_scaling import counts, machine, model  # noqa: E402

FOLD = SCENES / "small_fold.toml"
THROWN = SCENES / "three_grains.toml"


class Partitions(NappeTest):
    def test_counts_of_every_part_add_up(self):
        file = self.folder / "counts.json"
        result = call(["partitions", FOLD, "--parts", "1,3,400", "--tile-scale", "2", "--json", file])
        self.assertEqual(result.code, 0, str(result))
        by_grains, by_tiles, larger = counts.read(file)
        for cut in by_grains.cuts.values():
            self.assertEqual(cut.relaxations.sum(), by_grains.relaxations)
            self.assertEqual(cut.grains.sum(), by_grains.grains)
        self.assertEqual(list(by_grains.cuts), [1, 3, 400])
        self.assertEqual(len(by_grains.cuts[1].bytes), 0)
        self.assertGreater(len(by_grains.cuts[3].bytes), 4)
        self.assertTrue((by_grains.cuts[3].sender != by_grains.cuts[3].receiver).all())
        self.assertAlmostEqual(by_tiles.grains / by_grains.grains, 1, delta=0.15)  # surfaces weigh in a sample so small
        self.assertAlmostEqual(larger.grains / by_tiles.grains, 4, delta=0.05)  # slivers of tiles are left out
        for column in ("relaxations", "messages", "neighbours"):
            self.assertIn(column, result.out)

    def test_the_settled_sample_is_taken_from_a_store(self):
        run = self.run_scene(FOLD, "--steps", "0")
        command = ["partitions", FOLD, "--parts", "2"]
        settled = call([*command, "--samples", self.folder / "samples"])
        self.assertEqual(settled.code, 0, str(settled))
        self.assertIn(f"{run.summary['grains']} grains", settled.out)
        self.assertNotEqual(settled.out, call(command).out)

    def test_bad_input_is_named(self):
        file = self.folder / "not" / "there.json"
        for arguments, named, ranks, code in [
            ([FOLD, "--parts", "2,0"], "--parts", 0, 2),
            ([FOLD, "--scale", "-1"], "--scale", 0, 2),
            ([FOLD, "--tile-scale", "nan"], "--tile-scale", 0, 2),
            ([FOLD, "--samples", self.folder], "--samples", 0, 2),
            ([FOLD, *sets(tiles__side=9), "--tile-scale", "2"], "--tile-scale", 0, 2),
            ([THROWN, "--tile-scale", "2"], "--tile-scale", 0, 2),
            ([FOLD], "one rank", 2, 2),
            ([FOLD, "--parts", "2", "--json", file], "there.json", 0, 1),
        ]:
            with self.subTest(arguments=arguments):
                result = call(["partitions", *arguments], ranks)
                self.assertEqual(result.code, code, str(result))
                self.assertEqual(len(result.errors), 1, str(result))
                self.assertIn(named, result.errors[0])


def made_cut(interface, interior, messages):
    """messages: (from, colour, to, grains)."""
    columns = dict(zip(("from", "colour", "to", "grains"), zip(*messages))) if messages else {}
    data = {"parts": len(interface), "cut_seconds": 0, "grains": [100] * len(interface)}
    data |= {"interface": interface, "interior": interior}
    data["messages"] = {k: list(columns.get(k, [])) for k in ("from", "colour", "to", "grains")}
    return counts.Cut(data, 24)


class Model(unittest.TestCase):
    def assert_close(self, found, expected):
        self.assertAlmostEqual(found / expected, 1, places=9)  # sums of a few terms: round-off is far below

    def machine(self, **fields):
        """1 ns a relaxation, 1 µs a message, nothing else costs anything."""
        free = {"relaxation": [[1, 1.0], [1e12, 1.0]], "near_latency": 1e-6, "near_bandwidth": 1e30, "overhead": 0}
        free |= {"pack": 0, "node_cache": 1e30, "other": 0, "rebuild": 0, "alltoall": 0}
        data = json.loads((machine.FOLDER / "cluster.json").read_text()) | free | fields
        return machine.Machine(**data)

    def test_one_rank_only_relaxes(self):
        cut = made_cut([[0, 0, 0, 0]], [[1000, 2000, 3000, 4000]], [])
        one = model.sweep(cut, self.machine())
        for seconds in (one.work, one.coupled, one.barrier):
            self.assert_close(seconds, 10e-6)
        self.assertAlmostEqual(one.exposed, 0)
        self.assert_close(model.step(cut, self.machine(), 100).total, 101 * 10e-6)

    def test_interior_work_hides_a_message_or_not(self):
        messages = [(0, 0, 1, 10), (1, 0, 0, 10)]
        hidden = made_cut([[500, 0, 0, 0]] * 2, [[1500, 0, 0, 0]] * 2, messages)
        self.assert_close(model.sweep(hidden, self.machine()).coupled, 2e-6)
        shown = made_cut([[500, 0, 0, 0]] * 2, [[400, 0, 0, 0]] * 2, messages)
        one = model.sweep(shown, self.machine())
        self.assert_close(one.coupled, 1.5e-6)
        self.assert_close(one.work, 0.9e-6)
        self.assert_close(one.exposed, 0.4)
        slow = self.machine(near_bandwidth=1e9)  # 240 bytes take 0.24 µs
        self.assert_close(model.sweep(shown, slow).coupled, 1.74e-6)
        busy = self.machine(overhead=0.1e-6, pack=1e-9)  # before: 0.2 + 0.24, after: 0.1 + 0.24 µs
        self.assert_close(model.sweep(shown, busy).coupled, 1.5e-6 + 0.78e-6)
        self.assert_close(model.sweep(shown, busy).work, 0.9e-6 + 0.78e-6)

    def test_ranks_wait_for_neighbours_and_not_for_all(self):
        # Work of one colour on one rank, of the next on the other: only barriers would add the two up.
        cut = made_cut([[0] * 4] * 2, [[3000, 0, 0, 0], [0, 3000, 0, 0]], [])
        one = model.sweep(cut, self.machine())
        self.assert_close(one.work, 3e-6)
        self.assert_close(one.coupled, 3e-6)
        self.assert_close(one.barrier, 6e-6)

    def test_bounds_enclose_the_model(self):
        random = np.random.default_rng(1)
        for parts in (2, 5, 130):
            work = random.integers(0, 5000, (2, parts, 4)).tolist()
            drawn = random.integers(0, [parts, 4, parts], (6 * parts, 3)).tolist()
            ends = {(a, c, b) for a, c, b in drawn if a != b}
            cut = made_cut(*work, [(a, c, b, 50) for a, c, b in sorted(ends)])
            one = model.sweep(cut, machine.read("cluster"))
            self.assertLessEqual(one.work, one.coupled * (1 + 1e-12))  # sums in another order
            self.assertLessEqual(one.coupled, one.barrier * (1 + 1e-12))

    def test_beyond_the_cache_the_node_shares_its_memory(self):
        cut = made_cut([[0] * 4] * 2, [[1000] * 4] * 2, [])
        shared = self.machine(node_cache=1, node_memory_bandwidth=100e9, traffic=100)
        self.assert_close(model.sweep(cut, shared).coupled, 4000 * 2e-9)  # 2 ranks on 100 B/ns, 100 B each

    def test_messages_are_fitted(self):
        rows = [{"bytes": b, "one_way": [1e-6 + b / 2e9] * 2, "exchange": [4e-7] * 2} for b in (8, 1000, 100000)]
        latency, bandwidth, overhead = machine.fit_messages({"messages": rows})
        self.assert_close(latency, 1e-6)
        self.assertAlmostEqual(bandwidth / 2e9, 1)
        self.assert_close(overhead, 2e-7)


if __name__ == "__main__":
    main()
