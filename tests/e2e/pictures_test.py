"""From a scene to pictures: a short run of the quarter-scale fold on two ranks, then tools/plot and tools/render. Then
that run with the measures of a flow that is known, a trishear zone, for the pictures of fields and of several runs.

Usage: python3 pictures_test.py ROOT_OF_THE_REPOSITORY NAPPE FOLDER, with a Python that has matplotlib."""

import json
import math
import shutil
import subprocess
import sys
from pathlib import Path
from unittest import mock

import numpy as np
from matplotlib.colors import to_hex
from matplotlib.image import imread

STEPS = 40
SERIES = ["stress", "lambda", "front", "solver"]
CURVES_FROM_FRAMES = ["cells", "chains"]
FAULT = ["profile", "velocity", "trishear", "strain", "budget"]
IMPACT = ["gauges", "penetration", "impact"]
COMPARED = ["profile", "velocity", "trishear", "strain", "stress", "lambda", "cells", "zone", "budget", "chains"]
DIP, TIP, SPEED = math.radians(30), (100.0, 0.0), 0.5  # of the fault that is made up: a tip on the floor [m], [m/s]


def run(*command, code=0):
    """Its output, or what it says on standard error if it fails, with the exit code named. Libraries may say something
    there at any time: matplotlib does when it looks for fonts for the first time, on a slow machine."""
    done = subprocess.run([str(part) for part in command], capture_output=True, text=True)
    assert done.returncode == code, f"{command} returned {done.returncode}, not {code}:\n{done.stdout}\n{done.stderr}"
    return done.stdout + (done.stderr if code else "")


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


def check_trishear(fault):
    """The model the pictures draw: rigid above the zone, at rest below, continuous at its limits, free of divergence."""
    one = fault.Fault(TIP, (SPEED * math.cos(DIP), SPEED * math.sin(DIP)))
    half, s, r = math.radians(25), 1.7, 9.0
    zone = {"trishear_x": TIP[0], "trishear_y": TIP[1], "trishear_half_angle": half, "trishear_s": s}

    def at(angle, distance=r):
        """Velocity over SPEED at an angle from the fault: along the fault, across it."""
        x, y = TIP[0] + distance * math.cos(DIP + angle), TIP[1] + distance * math.sin(DIP + angle)
        velocity = fault.trishear(one, zone, np.array(x), np.array(y)) / SPEED
        return np.array([velocity @ one.along, velocity @ one.across])

    assert np.allclose(at(1.2 * half), [1, 0]) and np.allclose(at(-1.2 * half), [0, 0])
    near = 1e-9  # inside the limits; the model's slope is finite there
    assert np.allclose(at(half - near), [1, 0], atol=1e-7) and np.allclose(at(near - half), [0, 0], atol=1e-7)
    assert math.isclose(at(near)[0], 0.5, abs_tol=1e-3)  # on the fault: half the speed, and towards the footwall
    assert math.isclose(at(0.0)[1], -0.5 * math.tan(half) / (1 + s), rel_tol=1e-9)
    d = 1e-4  # m: second differences of the model are of order 1 a metre, so the divergence is off by 1e-8 or so
    for angle in (-0.8 * half, -0.3 * half, 0.2 * half, 0.7 * half):
        x, y = TIP[0] + r * math.cos(DIP + angle), TIP[1] + r * math.sin(DIP + angle)
        gx, gy = np.array([x + d, x - d, x, x]), np.array([y, y, y + d, y - d])
        v = fault.trishear(one, zone, gx, gy) / SPEED
        divergence = (v[0, 0] - v[1, 0] + v[2, 1] - v[3, 1]) / (2 * d)
        slopes = abs(v[0] - v[1]).max() / (2 * d)
        assert abs(divergence) < 1e-5 * max(slopes, 1), (angle, divergence, slopes)


def add_budget(folder):
    """Gives the series of energies the columns that output.measures.energy adds; they balance."""
    path = folder / "series/energy.csv"
    lines = path.read_text().splitlines()
    rows = [dict(zip(lines[0].split(","), line.split(","))) for line in lines[1:]]
    for row in rows:
        work = float(row["wall_work"])
        row |= {"gravity": -0.3 * work, "friction": 0.5 * work, "impact": 0.1 * work, "cohesion": 0.0}
        row |= {"theta_term": 0.0, "error": 0.0}
    path.write_text("\n".join([",".join(rows[0])] + [",".join(map(str, row.values())) for row in rows]) + "\n")


def check_fields(root, folder, out):
    """Pictures of one run with a fault, and of two."""
    sys.path.insert(0, str(Path(__file__).parent))
    import made_up_measures
    from nappe_plot import fault, flow

    check_trishear(fault)
    made_up_measures.add_fault(out, "piston", TIP, (SPEED * math.cos(DIP), SPEED * math.sin(DIP)))
    (out / "series").mkdir()
    for name in ("energy", "front", "solver", "cell-W1", "wall-piston"):
        shutil.copy(folder / "series" / f"{name}.csv", out / "series")
    add_budget(out)
    zone = made_up_measures.zone_values(DIP, TIP)
    one = fault.Fault(TIP, (SPEED * math.cos(DIP), SPEED * math.sin(DIP)))
    made_up_measures.make(out, lambda x, y: fault.trishear(one, zone, x, y), DIP, TIP, spacing=1.0)
    other = folder / "other"
    shutil.copytree(out, other)
    angle = made_up_measures.HALF_ANGLE
    figures = (out / "measures/zone.csv").read_text().replace(repr(angle), repr(2 * angle))
    (other / "measures/zone.csv").write_text(figures)

    pictures = out / "pictures"
    printed = run(root / "tools/plot", out, "--only", ",".join(FAULT), "--dpi", 80).splitlines()
    assert printed == [str(pictures / f"{name}.png") for name in FAULT], printed
    for name in FAULT:
        check_picture(pictures / f"{name}.png", ())
    moving, resting = (to_hex(flow.SPEEDS(flow.SPEED_NORM(speed))) for speed in (1.0, 0.0))
    check_picture(pictures / "velocity.png", (moving, resting))

    both = folder / "both"
    printed = run(root / "tools/plot", "--compare", out, other, "--labels", "right,wrong", "--out", both, "--dpi", 80)
    drawn = [line for line in printed.splitlines() if "skipped" not in line]
    assert drawn == [str(both / f"{name}.png") for name in COMPARED], printed
    for name in COMPARED:
        check_picture(both / f"{name}.png", ())
    # A fit that is the flow itself leaves no difference to show; one with twice the angle does, in its row.
    picture = imread(both / "trishear.png")
    misfit = np.array(flow.MISFITS(flow.MISFIT_NORM(0.2))[:3])
    shown = (abs(picture[..., :3] - misfit).max(axis=-1) < 0.1).sum(axis=1)
    top = len(picture) // 6  # the bars and their numbers lie above
    first, second = np.array_split(shown[top:], 2)
    assert first.sum() == 0 and second.sum() > 500, (first.sum(), second.sum())

    assert "--compare" in run(root / "tools/plot", out, other, code=2)
    assert "one label per folder" in run(root / "tools/plot", "--compare", out, other, "--labels", "a", code=2)
    printed = run(root / "tools/plot", "--compare", out, other, "--only", "solver", code=1)
    assert "no picture solver of several runs" in printed, printed


def check_impact_panels(impact, out):
    """Times below the lowest panel of each column, whatever the number of runs; rocks are in view as a whole."""
    from nappe_plot import run, views

    drawn = []
    with mock.patch.object(impact.style, "save", lambda figure, path, dpi: drawn.append(figure)):
        for n in (2, 3):
            list(impact.draw_gauges_compared(views.of_several([run.Run(out)] * n, "abc"[:n]), out))
        list(impact.draw_impact(run.Run(out), [0], out))

    def has_times(axis):
        return axis.xaxis.label.get_visible() and any(label.get_visible() for label in axis.get_xticklabels())

    told = [[has_times(axis) for axis in figure.axes] for figure in drawn[:2]]
    assert told == [[True, True], [False, True, True, False]], told
    frame = run.Run(out).frame(0)
    top = drawn[2].axes[0].get_ylim()[1]
    assert (frame.x[:, 1] + frame.radius).max() < top, (frame.x[-1], top)


def check_impact(root, nappe, folder):
    """Pictures of two rocks that fall on gauges, and of two such runs."""
    from nappe_plot import impact, palette

    out = folder / "rocks"
    gauges = [f'{{ name = "P{k}", wall = "box", from = {1.5 + 0.4 * k}, to = {1.9 + 0.4 * k}, every = 1 }}' for k in range(3)]
    strip = '{ name = "strip", wall = "box", from = 1.5, to = 2.7, bins = 12, every = 1 }'
    sensors = ("--set", f"output.gauges=[{', '.join([*gauges, strip])}]")
    sensors += ("--set", 'output.probes=[{ name = "rock", grain = -2, every = 1 }]')
    scene = root / "tests/support/scenes/small_rockfall.toml"
    run(nappe, "run", scene, "--out", out, "--samples", folder / "samples", *sensors)
    pictures = out / "pictures"
    printed = run(root / "tools/plot", out, "--only", ",".join(IMPACT), "--times", "0,0.03,0.06", "--dpi", 80).splitlines()
    assert printed == [str(pictures / f"{name}.png") for name in IMPACT], printed
    check_picture(pictures / "gauges.png", palette.LINES[:3])  # a line each
    check_picture(pictures / "penetration.png", palette.LINES[:1])
    # Grains that bear nothing, and the bars.
    check_picture(pictures / "impact.png", (to_hex(impact.FORCE(0.0)), palette.LINES[1]))
    both = folder / "falls"
    printed = run(root / "tools/plot", "--compare", out, out, "--labels", "a,b", "--only", "gauges,penetration,chains", "--until", 0.05, "--out", both, "--dpi", 80)
    assert printed.splitlines() == [str(both / f"{name}.png") for name in (*IMPACT[:2], "chains")], printed
    check_picture(both / "gauges.png", palette.LINES[:3])
    check_impact_panels(impact, out)
    # A panel each, of the last frame, as the run's own at that time.
    run(root / "tools/plot", out, "--only", "chains", "--times", "0.06", "--dpi", 80)
    one, two = (imread(folder / "chains.png") for folder in (pictures, both))
    assert two.shape[0] > 1.6 * one.shape[0] and two.shape[1] == one.shape[1], (one.shape, two.shape)


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
    drawn = [line for line in printed if "skipped" not in line]
    assert sorted(drawn) == sorted(map(str, expected)), printed
    skipped = [line.split(":")[0] for line in printed if "skipped" in line]
    assert skipped == FAULT + IMPACT, printed  # the fold has no fault, was not measured, and nothing falls on it
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
    shutil.copytree(out / "series", folder / "series")
    shutil.rmtree(out / "series")
    printed = run(root / "tools/plot", out, "--only", ",".join(SERIES))
    assert printed.count("skipped") == len(SERIES), printed
    assert "no run.xdmf" in run(root / "tools/plot", folder, code=1)
    check_fields(root, folder, out)
    check_impact(root, nappe, folder)
    print("the fold ran, and every picture shows something")


main(Path(sys.argv[1]).resolve(), Path(sys.argv[2]), Path(sys.argv[3]).resolve())
