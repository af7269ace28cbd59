"""Input that asks for too much, as its users see it: exit code 2, a message with the number, nothing allocated for it and
no folder made; and a stored sample that is none is made anew."""

import pathlib
import resource
import sys

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parent.parent / "support"))
from nappe_driver import SCENES, NappeTest, call, main  # noqa: E402

FOLD = SCENES / "small_fold.toml"
BAD_INPUT = 2
LARGEST = 1 << 20  # kB: what the program, MPI and python take is a tenth of it, what these scenes ask for a million times


class BadInput(NappeTest):
    def cases(self):
        """Arguments after the command, and what the message must say."""
        text = self.folder / "text.toml"
        text.write_bytes(FOLD.read_bytes().replace(b"a small fold", b"\xff\xfe"))
        deep = self.folder / "deep.toml"
        deep.write_text("x" + ".x" * 1000000 + " = 1\n")
        brackets = self.folder / "brackets.toml"
        brackets.write_text("x = " + "[" * 1000000)
        return [
            ([FOLD, "--set", "sample.radius={ law = \"constant\", value = 1e-8 }", "--set", "tiles={}"],
             "sample.profile: must hold at most 1e+09 grains, found room for"),
            ([FOLD, "--set", "sample.profile=[[0,0],[1e9,0],[1e9,1e9],[0,1e9]]"],
             "must hold at most 1e+09 grains, found room for 1.9e+18"),
            ([FOLD, "--set", "stages.push.duration=1e25"], "must be at most 2^53 steps, found 1e+25 s"),
            ([FOLD, "--set", "materials.rock.density=1e300"], "must lie within ±1e+30"),
            ([FOLD, "--set", "solver.sweeps=3000000000"], "must be an integer in [1, 500000000], found 3000000000"),
            ([FOLD, "--set", "output.measures.spacing=1e-9"], "must be at least a hundredth of the smallest radius"),
            ([FOLD, "--set", "output.front_bin=1e-12"], "must be at least a hundredth of the smallest radius"),
            ([FOLD, "--set", "solver.h=" + "[" * 100000], "the value must be TOML on one line"),
            ([text], "text.toml:3: must be valid TOML"),
            ([deep], "deep.toml:1: must have at most 32 dots in a key"),
            ([brackets], "brackets.toml:1: must be valid TOML"),
            (["/dev/zero"], "must be a scene file of at most 64 MiB"),
            ([self.folder], "found a directory"),
        ]

    def expect(self, command, ranks):
        for arguments, message in self.cases():
            with self.subTest(command=command, message=message):
                out = ["--out", self.folder / "out"] if command == "run" else []
                result = call([command, *arguments, *out], ranks, self.folder)
                self.assertEqual(result.code, BAD_INPUT, str(result)[:2000])
                self.assertIn(message, result.err)
                self.assertEqual(result.err.count("nappe: "), 1, result.err[:2000])
                self.assertLess(len(result.err), 20000)
                self.assertFalse((self.folder / "out").exists())
        self.assertLess(resource.getrusage(resource.RUSAGE_CHILDREN).ru_maxrss, LARGEST)

    def test_check(self):
        self.expect("check", 0)

    def test_run_on_two_ranks(self):
        self.expect("run", 2)

    def test_a_spoiled_sample_is_made_anew_and_nobody_hears_of_hdf5(self):
        arguments = ["--steps", "2"]
        first = self.run_scene(FOLD, *arguments, out="first")
        path = next((self.folder / "samples").glob("*.hdf"))
        sound = path.read_bytes()
        for spoiled in (sound[:-1], sound[: len(sound) // 2], b"", bytes([sound[0] ^ 1]) + sound[1:]):
            path.write_bytes(spoiled)
            again = self.run_scene(FOLD, *arguments, out="again")
            self.assertIn("settled sample: to be made (", again.result.err + again.result.out)
            self.assertNotIn("HDF5-DIAG", again.result.err + again.result.out)
            self.assertEqual(again.summary["state_hash"], first.summary["state_hash"])
            self.assertEqual(path.read_bytes(), sound)


if __name__ == "__main__":
    main()
