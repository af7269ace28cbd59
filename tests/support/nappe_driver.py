"""Runs the built program for tests written in Python, and reads what it leaves. A test file ends with main(), and ctest
calls it as: TEST.py --nappe PATH --mpirun PATH [arguments of unittest]. Every run has a time limit: a hang is a
failure."""

import argparse
import csv
import json
import os
import pathlib
import shutil
import signal
import subprocess
import sys
import tempfile
import unittest

SCENES = pathlib.Path(__file__).parent / "scenes"
TIME_LIMIT = 300  # s; runs take one to four on an idle machine, a hundred times that beside other work
WALL_KEY = 1 << 62

paths = argparse.Namespace(nappe=None, mpirun=None)


class Result:
    def __init__(self, code, out, err):
        self.code = code
        self.out = out
        self.err = err

    @property
    def errors(self):
        """What the program itself said went wrong, line by line."""
        return [line for line in self.err.splitlines() if line.startswith("nappe: ")]

    def __str__(self):
        return f"exit code {self.code}\n{self.out}\n{self.err}"


def command(arguments, ranks):
    """ranks 0: the program alone, as a user would start it without mpirun."""
    program = [paths.nappe, *map(str, arguments)]
    return program if ranks == 0 else [paths.mpirun, "-n", str(ranks), *program]


def start(arguments, ranks=0, folder=None, **environment):
    return subprocess.Popen(
        command(arguments, ranks),
        cwd=folder,
        env=dict(os.environ, NAPPE_YIELD="1", **environment),
        stdin=subprocess.DEVNULL,
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
        start_new_session=True,
    )


def finish(process, limit=TIME_LIMIT):
    try:
        out, err = process.communicate(timeout=limit)
    except subprocess.TimeoutExpired:
        os.killpg(process.pid, signal.SIGKILL)
        out, err = process.communicate()
        raise AssertionError(f"still running after {limit} s: {process.args}\n{out}\n{err}") from None
    return Result(process.returncode, out, err)


def call(arguments, ranks=0, folder=None):
    return finish(start(arguments, ranks, folder))


class Run:
    """A finished run and its files."""

    def __init__(self, out, result):
        self.out = pathlib.Path(out)
        self.result = result

    @property
    def summary(self):
        return json.loads((self.out / "summary.json").read_text())

    @property
    def hash(self):
        return self.summary["state_hash"]

    def series(self, name):
        """Column name -> list of numbers."""
        with open(self.out / "series" / f"{name}.csv", newline="") as file:
            rows = list(csv.reader(file))
        return {column: [float(row[k]) for row in rows[1:]] for k, column in enumerate(rows[0])}

    def files(self):
        """Relative names of everything in the folder."""
        return sorted(str(p.relative_to(self.out)) for p in self.out.rglob("*") if p.is_file())


class NappeTest(unittest.TestCase):
    """Each test has a folder of its own, gone afterwards."""

    @classmethod
    def setUpClass(cls):
        cls.class_folder = pathlib.Path(tempfile.mkdtemp(prefix="nappe-test-"))
        cls.addClassCleanup(shutil.rmtree, cls.class_folder, ignore_errors=True)

    def setUp(self):
        self.folder = pathlib.Path(tempfile.mkdtemp(dir=self.class_folder))

    def run_scene(self, scene, *arguments, ranks=0, out="out", samples="samples", code=0):
        folders = ["--out", self.folder / out, "--samples", self.folder / samples]
        # Tests run several scenes into one folder; that it takes --overwrite is tested in tests/faults.
        result = call(["run", scene, *folders, "--overwrite", *arguments], ranks, self.folder)
        self.assertEqual(result.code, code, str(result))
        return Run(self.folder / out, result)


def sets(**keys):
    """sets(solver__h=0.01) is ["--set", "solver.h=0.01"]."""
    arguments = []
    for key, value in keys.items():
        arguments += ["--set", f"{key.replace('__', '.')}={value}"]
    return arguments


def main():
    parser = argparse.ArgumentParser()
    parser.add_argument("--nappe", required=True)
    parser.add_argument("--mpirun", required=True)
    _, rest = parser.parse_known_args(namespace=paths)
    paths.nappe, paths.mpirun = map(os.path.abspath, (paths.nappe, paths.mpirun))  # runs have other working directories
    unittest.main(module="__main__", argv=[sys.argv[0], *rest], verbosity=2)
