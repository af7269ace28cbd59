"""Series of gauges and probes: against those of the walls, against each other and against frames."""

import pathlib
import sys

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parent.parent / "support"))
from nappe_driver import SCENES, NappeTest, Run, call, main, sets  # noqa: E402

import h5py  # noqa: E402
import numpy as np  # noqa: E402

LENGTH, HEIGHT, H = 40.0, 20.0, 0.025  # m of floor and piston, s a step
GAUGES = """[
  { name = "each", wall = "floor", bins = 20, every = 1 },
  { name = "rare", wall = "floor", bins = 20, every = 7 },
  { name = "part", wall = "floor", from = 2, to = 10, bins = 4, every = 7 },
  { name = "push", wall = "piston", bins = 3 },
]""".replace("\n", "")
PROBES = '[{ name = "five", grain = 5, every = 7 }, { name = "last", grain = -1 }]'


class Sensors(NappeTest):
    @classmethod
    def setUpClass(cls):
        super().setUpClass()
        out, samples = cls.class_folder / "out", cls.class_folder / "samples"
        keys = sets(output__series__every=1, output__gauges=GAUGES, output__probes=PROBES)
        result = call(["run", SCENES / "small_fold.toml", "--out", out, "--samples", samples, *keys], ranks=2)
        assert result.code == 0, str(result)
        cls.fold = Run(out, result)

    def series(self, name, run=None):
        return {column: np.array(values) for column, values in (run or self.fold).series(name).items()}

    def pressures(self, name):
        """Steps, and normal and tangential force per length: a row a time, a column a bin."""
        series = self.series(name)
        n = sum(column.startswith("normal_") for column in series)
        return series["step"], *(np.stack([series[f"{part}_{k}"] for k in range(n)], 1) for part in ("normal", "tangential"))

    def assert_near(self, found, expected, message):
        """But for the order of a sum's terms."""
        scale = np.max(np.abs(expected))
        self.assertGreater(scale, 0, "the case is none")
        np.testing.assert_allclose(found, expected, rtol=1e-11, atol=1e-11 * scale, err_msg=message)

    def test_bins_of_a_wall_add_up_to_its_force_in_every_row(self):
        floor, piston = self.series("wall-floor"), self.series("wall-piston")
        _, normal, tangential = self.pressures("gauge-each")
        width = LENGTH / 20
        self.assert_near(width * normal.sum(1), -floor["fy"], "pressing down; the first row is of the sample at rest")
        self.assert_near(width * tangential.sum(1), floor["fx"], "from the first point to the last")
        self.assertGreater(normal.max(), 3 * np.median(normal), "bins differ")
        _, normal, tangential = self.pressures("gauge-push")
        self.assert_near(HEIGHT / 3 * normal.sum(1), -piston["fx"], "pressing from the right")
        self.assert_near(HEIGHT / 3 * tangential.sum(1), -piston["fy"], "from the top to the foot")

    def test_a_row_is_the_mean_since_the_row_before(self):
        _, *each = self.pressures("gauge-each")
        steps, *rare = self.pressures("gauge-rare")
        self.assertEqual(list(steps), [0, *range(7, 57, 7), 60], "the last is of what is left")
        for found, single in zip(rare, each):
            ends = steps.astype(int)
            means = [single[a + 1 : b + 1].mean(0) for a, b in zip(ends, ends[1:])]
            self.assert_near(found[0], single[0], "the sample's")
            self.assert_near(found[1:], np.array(means), "of the steps between")

    def test_a_part_has_the_bins_of_the_whole(self):
        _, *whole = self.pressures("gauge-rare")
        _, *part = self.pressures("gauge-part")
        for found, expected in zip(part, whole):
            self.assert_near(found, expected[:, 1:5], "2 to 10 m in bins of 2 m")

    def test_probes_are_where_frames_have_their_grains(self):
        five, last = self.series("probe-five"), self.series("probe-last")
        self.assertEqual(list(five["step"]), [0, *range(7, 57, 7), 60])
        n = self.fold.summary["grains"]
        for step in (0, 30, 60):
            with h5py.File(self.fold.out / "frames" / f"frame-{step:08}.hdf") as file:
                ids = file["VTKHDF/PointData/id"][:]
                for probe, grain in ((five, 5), (last, n - 1)):
                    if step not in probe["step"]:
                        continue
                    row, at = np.flatnonzero(probe["step"] == step)[0], np.flatnonzero(ids == grain)[0]
                    x, v = file["VTKHDF/Points"][at], file["VTKHDF/PointData/velocity"][at]
                    self.assertEqual([probe["x"][row], probe["y"][row]], list(x[:2]))
                    self.assertEqual([probe["vx"][row], probe["vy"][row]], list(v[:2]))
        np.testing.assert_array_equal(last["penetration"], last["y"][0] - last["y"], "gravity pulls along -y")
        self.assertGreater(np.ptp(last["y"]), 0)

    def test_a_dropped_grain_is_probed_from_its_first_touch(self):
        scene = SCENES / "small_rockfall.toml"
        run = self.run_scene(scene, *sets(output__probes='[{ name = "rock", grain = -1, every = 1 }]'))
        rock = self.series("probe-rock", run)
        self.assertEqual([rock[key][0] for key in ("vx", "vy", "spin", "penetration")], [-0.8, -2.4, 20, 0])
        self.assertEqual(rock["x"][0], 0.342, "it goes along gravity only")
        self.assertGreater(rock["penetration"].max(), 0.01)


main()
