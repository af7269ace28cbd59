"""When stages that prepare a sample end: as soon as both that they ask for have hold, and not before."""

import pathlib
import re
import sys

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parent.parent / "support"))
from nappe_driver import SCENES, NappeTest, main, sets  # noqa: E402

FOLD = SCENES / "small_fold.toml"
SPRINGS = sets(
    **{f"laws__{k}__{key}": value for k in (0, 1) for key, value in (("type", "cundall"), ("k_n", 5e7))},
    materials__rock__damping=3000,
    stages__settle__solver='{ method = "cundall", h = 2e-4 }',
)


class Settling(NappeTest):
    def settled(self, keys, rest, kinetic, wanted):
        """Steps it took, and both figures at the end, of which the run tells."""
        until = "{ " + f"kinetic = {kinetic}, {rest} = {wanted}, at_most = 50" + " }"
        run = self.run_scene(FOLD, *keys, *sets(stages__settle__until=until), "--steps", 0)
        name = "unbalanced force" if rest == "unbalanced" else rest
        said = re.search(rf"settled after (\d+) steps: kinetic (\S+), {name} (\S+)", run.result.err)
        self.assertIsNotNone(said, run.result.err)
        return int(said[1]), float(said[2]), float(said[3])

    def check(self, keys, rest, loose, tight):
        any_kinetic, small_kinetic = 1e3, 1e-5
        n, _, left = self.settled(keys, rest, any_kinetic, loose)
        self.assertLessEqual(left, loose)
        self.assertGreater(left, tight, "the case is none: what is looser is tight already")
        longer, _, left = self.settled(keys, rest, any_kinetic, tight)
        self.assertLessEqual(left, tight)
        self.assertGreater(longer, n)
        slower, kinetic, _ = self.settled(keys, rest, small_kinetic, 1e3)
        self.assertLessEqual(kinetic, small_kinetic)
        both, kinetic, left = self.settled(keys, rest, small_kinetic, tight)
        self.assertLessEqual(kinetic, small_kinetic)
        self.assertLessEqual(left, tight)
        self.assertGreaterEqual(both, max(slower, longer))

    def test_springs_by_unbalanced_force(self):
        self.check(SPRINGS, "unbalanced", 0.2, 3e-3)

    def test_sweeps_by_residual(self):
        self.check([], "residual", 0.5, 1e-2)


main()
