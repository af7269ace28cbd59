"""From a scene to pictures: a short run of the quarter-scale fold on two ranks, then tools/plot and tools/render.

Usage: python3 pictures_test.py ROOT_OF_THE_REPOSITORY NAPPE FOLDER, with a Python that has matplotlib."""

import json
import shutil
import subprocess
import sys
from pathlib import Path

import numpy as np
from matplotlib.image import imread

STEPS = 40
SERIES = ["stress", "lambda", "front", "solver"]
CURVES_FROM_FRAMES = ["cells", "chains"]


def run(*command, code=0):
    """Its output, both streams; the exit code must be the one named."""
    done = subprocess.run([str(part) for part in command], stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True)
    assert done.returncode == code, f"{command} returned {done.returncode}, not {code}:\n{done.stdout}"
    return done.stdout


def has_colour(picture, colour):
    """Whether a thousand pixels are of nearly this colour: a legend's patch has some two hundred, a line or a layer of
    grains several thousand. Shades vary by a tenth from grain to grain."""
    wanted = np.array([int(colour[i : i + 2], 16) / 255 for i in (1, 3, 5)])
    return (abs(picture[..., :3] - wanted).max(axis=-1) < 0.08).sum() > 1000


def check_picture(path, palette):
    assert path.is_file(), f"{path} was not drawn"
    picture = imread(path)
    assert min(picture.shape[:2]) > 150, (path, picture.shape)
    assert picture[..., :3].std() > 0.02, f"{path} is blank"
    for colour in palette:
        assert has_colour(picture, colour), f"{path} shows nothing in {colour}"


def main(root, nappe, folder):
    sys.path.insert(0, str(root / "tools"))
    from nappe_plot import palette

    shutil.rmtree(folder, ignore_errors=True)
    out, pictures = folder / "fold", folder / "fold" / "pictures"
    outputs = ("--set", "output.frames.every=20", "--set", "output.series.every=1")
    scene = root / "jobs/fold-small.toml"
    run(root / "tools/mpirun", "-n", 2, nappe, "run", scene, "--out", out, "--steps", STEPS, *outputs)
    steps = json.loads((out / "summary.json").read_text())["steps"]
    assert steps == STEPS, steps

    printed = run(root / "tools/plot", out, "--times", "0,1", "--dpi", 80).splitlines()
    layers = ["layers", "layers-0000s", "layers-0001s"]
    expected = [pictures / f"{name}.png" for name in layers + SERIES + CURVES_FROM_FRAMES]
    assert sorted(printed) == sorted(map(str, expected)), printed
    bed = palette.BED[0], palette.BED[2], palette.BED[4], palette.ABOVE_BED
    for path in expected:
        check_picture(path, bed if path.stem in layers else ())
    check_picture(pictures / "stress.png", palette.LINES[:6])  # six cells, one colour each

    printed = run(root / "tools/render", out, "--times", "0,1", "--width", 1200).splitlines()
    rendered = [pictures / f"paraview-{name}.png" for name in ("0000s", "0001s")]
    assert [line for line in printed if line.endswith(".png")] == list(map(str, rendered)), printed
    for path in rendered:
        check_picture(path, ())

    # What a run does not have is skipped and named; what is no run is refused.
    shutil.rmtree(out / "series")
    printed = run(root / "tools/plot", out, "--only", ",".join(SERIES))
    assert printed.count("skipped") == len(SERIES), printed
    assert "no run.xdmf" in run(root / "tools/plot", folder, code=1)
    print("the fold ran, and every picture shows something")


main(Path(sys.argv[1]).resolve(), Path(sys.argv[2]), Path(sys.argv[3]).resolve())
