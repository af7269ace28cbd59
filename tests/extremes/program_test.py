"""The extremes that need the whole program: coordinates far away, ranks without grains, worlds thinner than a tile, what is
refused and with which exit code, and (NAPPE_EXTREMES=long) a pile of a million grains."""

import os
import pathlib
import re
import sys
import unittest

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parent.parent / "support"))
from nappe_driver import NappeTest, call, main, sets  # noqa: E402

import h5py  # noqa: E402
import numpy as np  # noqa: E402

DONE, BAD_INPUT, NUMERICAL = 0, 2, 4
LONG = os.environ.get("NAPPE_EXTREMES") == "long"


def found(table, *columns):
    print("found | " + " | ".join([table, *map(str, columns)]) + " |", flush=True)


def point(x, y, shift):
    """As a file far away has it: repr is exact, and so is the sum, since coordinates are binary fractions."""
    assert (x + shift) - shift == x and (y + shift) - shift == y, (x, y, shift)
    return f"[{x + shift!r}, {y + shift!r}]"


HEAD = """
[world]
gravity = [0.0, -9.81]
origin = {origin}
[materials.rock]
density = 2800.0
[[laws]]
between = ["rock", "rock"]
type = "frictional"
friction = 0.4
[[laws]]
between = ["rock", "wall"]
type = "frictional"
friction = 0.4
"""

BOX = (
    HEAD
    + """
[sample]
material = "rock"
radius = {{ law = "uniform", min = 0.25, max = 0.5 }}
profile = [{p00}, {p10}, {p11}, {p01}]
layers = {{ count = 2, from = {foot}, to = {top} }}
[[walls]]
name = "floor"
points = [{p00}, {p10}]
[[walls]]
name = "piston"
points = [{left}, {p00}]
motion = {{ stage = "push", velocity = [1.0, 0.0] }}
[[walls]]
name = "right"
points = [{p10}, {right}]
[[stages]]
name = "settle"
until = {{ kinetic = 1e-4, residual = 0.05 }}
[[stages]]
name = "push"
duration = 0.5
[solver]
h = 0.0125
sweeps = 20
[tiles]
side = {side}
[balance]
threshold = 1.0
every = 5
moves = "always"
[output]
frames = {{ every = 20 }}
series = {{ every = 10 }}
cells = [{{ name = "W1", centre = {cell}, radius = 1.5 }}]
measures = {{ during_run = true, energy = true }}
"""
)


def box(width, height, shift=0.0, side=4.0):
    """A box of settled disks that a piston pushes, all of it shifted along both axes."""
    at = lambda x, y: point(x, y, shift)  # noqa: E731
    return BOX.format(
        origin=at(0.0, 0.0),
        p00=at(0.0, 0.0),
        p10=at(width, 0.0),
        p11=at(width, height),
        p01=at(0.0, height),
        left=at(0.0, height + 8.0),
        right=at(width, height + 8.0),
        cell=at(width / 2, height / 2),
        foot=repr(0.0 + shift),
        top=repr(height + shift),
        side=side,
    )


LEAD = """[materials.lead]
density = 2.8e9
""" + "".join(f"""[[laws]]
between = ["lead", "{other}"]
type = "frictional"
friction = 0.4
""" for other in ("lead", "rock", "wall"))


def grains(*rows, walls="", duration=0.5, h=0.01):
    """Single grains: (radius, x, y, vx, vy), of rock, or of what a sixth column says."""
    text = HEAD.format(origin="[0.0, 0.0]") + LEAD
    for r, x, y, vx, vy, *material in rows:
        text += f'[[grains]]\nmaterial = "{(material or ["rock"])[0]}"\nradius = {r}\n'
        text += f"position = [{x}, {y}]\nvelocity = [{vx}, {vy}]\n"
    return text + walls + f'[[stages]]\nname = "go"\nduration = {duration}\n[solver]\nh = {h}\nsweeps = 20\n'


FLOOR = '[[walls]]\nname = "floor"\npoints = [[-20, 0], [20, 0]]\n'
CLOSING = """[[walls]]
name = "left"
points = [[-2, 9], [-2, -1]]
motion = { stage = "go", velocity = [1, 0] }
[[walls]]
name = "right"
points = [[2, -1], [2, 9]]
motion = { stage = "go", velocity = [-1, 0] }
"""


class Program(NappeTest):
    def scene(self, name, text):
        path = self.folder / name
        path.write_text(f'title = "{name}"\n' + text)
        return path


class Origin(Program):
    def test_shifted_scenes_give_the_same_bits(self):
        near = self.run_scene(self.scene("near.toml", box(12.0, 3.0)), ranks=1, out="near", samples="near-samples")
        x = self.points(near)
        for shift, ranks in ((1e6, 1), (1e9, 3), (-1e6, 2), (-1e9, 1), (0.0, 5)):
            with self.subTest(shift=shift, ranks=ranks):
                name = f"far{int(shift)}"
                scene = self.scene(f"{name}.toml", box(12.0, 3.0, shift))
                far = self.run_scene(scene, ranks=ranks, out=name, samples=f"{name}-samples")
                self.assertEqual(far.hash, near.hash)
                for key in ("relaxations", "rebuilds", "overlap_max", "residual", "settle_steps"):
                    self.assertEqual(far.summary[key], near.summary[key], key)
                for name_of in ("solver", "energy", "wall-piston", "cell-W1"):
                    file = f"series/{name_of}.csv"
                    self.assertEqual((far.out / file).read_bytes(), (near.out / file).read_bytes())
                # Files have the file's coordinates: half a step of a double there, 6e-8 m at 1e9 m.
                self.assertLessEqual(np.abs(self.points(far) - shift - x).max(), 0.6 * np.spacing(abs(shift) + 20))
                found("origin", f"{shift:g}", ranks, far.hash == near.hash)

    def points(self, run):
        with h5py.File(run.out / "frames/frame-00000040.hdf") as file:
            return file["VTKHDF/Points"][:, :2]

    def test_a_sample_serves_wherever_its_scene_lies(self):
        near = self.run_scene(self.scene("near.toml", box(12.0, 3.0)), ranks=2)
        far = self.run_scene(self.scene("far.toml", box(12.0, 3.0, 1e9)), ranks=2, out="far")
        self.assertFalse(near.summary["sample_reused"])
        self.assertTrue(far.summary["sample_reused"])
        self.assertEqual(far.hash, near.hash)

    def test_measures_are_those_of_the_files(self):
        """Frames round positions at 1e9 m; measures taken in the run and afterwards are of the same numbers."""
        run = self.run_scene(self.scene("far.toml", box(12.0, 3.0, 1e9)), ranks=2)
        again = call(["measure", run.out, "--out", self.folder / "again"], ranks=3)
        self.assertEqual(again.code, DONE, str(again))
        csv = sorted(p.name for p in (run.out / "measures").glob("*.csv"))
        self.assertIn("surface.csv", csv)
        for name in csv:
            self.assertEqual((self.folder / "again" / name).read_bytes(), (run.out / "measures" / name).read_bytes())
        with h5py.File(run.out / "measures/fields/fields-00000040.hdf") as file:
            corner = file["VTKHDF"].attrs["Origin"]
            profile = file["profile/surface"][()]
        self.assertLess(abs(corner[0] - 1e9), 20)
        self.assertLess(np.nanmax(np.abs(profile - 1e9)), 20)


class Ranks(Program):
    def same_on(self, scene, counts, *arguments):
        one = self.run_scene(scene, *arguments, ranks=1, out="out-1", samples="samples-1")
        for n in counts:
            with self.subTest(ranks=n):
                many = self.run_scene(scene, *arguments, ranks=n, out=f"out-{n}", samples=f"samples-{n}")
                self.assertEqual(many.hash, one.hash)
                self.assertEqual(many.summary["ranks"], n)
        return one

    def test_one_and_two_grains_on_seven_ranks(self):
        for n in (1, 2):
            scene = self.scene(f"{n}.toml", grains(*[(0.5, 0.4 * k, 1.0 + 1.1 * k, 0.3, 0.0) for k in range(n)], walls=FLOOR))
            one = self.same_on(scene, (2, 7))
            self.assertEqual(one.summary["grains"], n)
            self.assertGreater(one.summary["relaxations"], 0, "nothing touched: the case is too easy")
            found("ranks", f"{n} grains", 7, "same bits")

    def test_no_grain_is_refused(self):
        for ranks in (1, 7):
            result = call(["run", self.scene("none.toml", grains(walls=FLOOR))], ranks, self.folder)
            self.assertEqual(result.code, BAD_INPUT, str(result))
            self.assertEqual(len(result.errors), 1, result.err)
            self.assertIn("a scene must have grains", result.err)
        found("ranks", "0 grains", 7, "refused, code 2")

    def test_world_thinner_than_a_tile(self):
        for side in (4.0, 30.0):
            scene = self.scene(f"thin{side}.toml", box(24.0, 1.0, side=side))
            one = self.same_on(scene, (2, 7))
            self.assertLess(one.summary["overlap_max"], 0.2)
            found("ranks", f"24 m x 1 m on tiles of {side:g} m", 7, "same bits")


class Refusals(Program):
    def test_centres_that_coincide_are_bad_input(self):
        cases = {
            "coincide": grains((0.5, 3, 1, 0, 0), (0.5, 3, 1, 0, 0)),
            "within": grains((0.5, 3, 1, 0, 0), (0.25, 3.25, 1, 0, 0)),
            "on-wall": grains((0.5, 3, 0, 0, 0), walls=FLOOR),
        }
        for name, text in cases.items():
            for ranks in (1, 3):
                with self.subTest(name=name, ranks=ranks):
                    result = call(["run", self.scene(f"{name}.toml", text)], ranks, self.folder)
                    self.assertEqual(result.code, BAD_INPUT, str(result))
                    self.assertEqual(len(result.errors), 1, result.err)
                    self.assertIn("grains.", result.err)
            found("refusals", name, 2)

    def test_what_goes_wrong_later_is_told_alike_on_any_number_of_ranks(self):
        inside = "came into the other, or went through it"
        cases = {
            "walls that close": (grains((0.5, 0, 0.5, 0, 0), walls=FLOOR + CLOSING, duration=9), "went through wall '"),
            "first step through a grain": (grains((0.5, 0, 1, 400, 0), (0.5, 1.25, 1, 0, 0)) + "[tiles]\nside = 60\n", inside),
            "heavy on light": (grains((0.5, 0, 0.5, 0, 0), (0.5, 0, 1.5, 0, 0, "lead"), walls=FLOOR, duration=9), inside),
            "too fast": (grains((0.5, 0, 1, 4000, 0)), "farther than tiles allow"),
        }
        for name, (text, said) in cases.items():
            messages = set()
            for ranks in (1, 3):
                with self.subTest(name=name, ranks=ranks):
                    run = self.run_scene(self.scene("case.toml", text), ranks=ranks, out=f"{name}-{ranks}", code=NUMERICAL)
                    self.assertEqual(len(run.result.errors), 1, run.result.err)
                    self.assertIn(said, run.result.errors[0])
                    self.assertNotIn("summary.json", run.files())
                    messages.add(run.result.errors[0])
            self.assertEqual(len(messages), 1, messages)
            found("refusals", name, 4, re.sub(r"; .*", "", messages.pop().removeprefix("nappe: ")))


@unittest.skipUnless(LONG, "only in the long form")
class Pile(Program):
    def test_a_million_grains(self):
        scene = self.scene("million.toml", box(4096.0, 144.0, side=16.0).replace("duration = 0.5", "duration = 0.125"))
        # Not settled: a bed as deposited, pushed for ten steps.
        text = re.sub(r'\[\[stages\]\]\nname = "settle"\n.*\n', "", scene.read_text())
        scene.write_text(text.replace("during_run = true, ", ""))
        one = self.run_scene(scene, ranks=1, out="one")
        two = self.run_scene(scene, ranks=2, out="two")
        self.assertGreater(one.summary["grains"], 1_000_000)
        self.assertEqual(two.hash, one.hash)
        self.assertLess(one.summary["overlap_max"], 0.5)
        found("pile", one.summary["grains"], one.summary["contacts"], f"{one.summary['overlap_max']:.3g}", "same bits")


if __name__ == "__main__":
    main()
