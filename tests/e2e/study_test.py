"""tools/fault_study: its list, the order in which it runs, its resuming, its report.

Usage: python3 study_test.py ROOT_OF_THE_REPOSITORY NAPPE FOLDER [NAME OF A TEST], with a Python that has matplotlib."""

import itertools
import json
import math
import os
import re
import shlex
import shutil
import signal
import subprocess
import sys
import time
from pathlib import Path

import numpy as np

ROOT, NAPPE, FOLDER = Path(sys.argv[1]).resolve(), Path(sys.argv[2]), Path(sys.argv[3]).resolve()
sys.path[:0] = [str(ROOT / "tools"), str(ROOT / "tests/e2e")]

import made_up_measures  # noqa: E402
from nappe_study import plan, reference, report, results  # noqa: E402
from nappe_study import fits as fits_module  # noqa: E402
from nappe_study.fits import Study  # noqa: E402

TOOL = ROOT / "tools/fault_study"
STEP = 0.01  # s
HALF_ANGLE = 5.0  # degrees, of the made-up zones: their right limits stay clear of the box's end
# Takes --set as nappe does, writes what the tool looks at and a diary of it; one run can be told to fail.
STAND_IN = f'''#!{sys.executable}
import pathlib, sys, time
sys.path[:0] = {sys.path[:2]!r}
sys.argv[1:], told = [{str(ROOT)!r}, "", ""], sys.argv[1:]
import study_test
study_test.stand_in(told)
'''


def run_tool(*arguments, code=0):
    done = subprocess.run([TOOL, *map(str, arguments)], stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True)
    assert done.returncode == code, f"fault_study {arguments} returned {done.returncode}, not {code}:\n{done.stdout}"
    return done.stdout


def scene_text(settings):
    """The part of the scene as run that the tool reads; settings: values as --set takes them, by key."""
    at = {key: value for key, value in settings.items()}
    return f"""
[world]
gravity = [0.0, -9.81]
[materials.rock]
density = 2800.0
gamma = {at["materials.rock.gamma"]}
[sample]
radius = {{ law = "uniform", min = 0.13, max = 0.26 }}
profile = {at["sample.profile"]}
layers = {{ count = 10, from = 0, to = {at["sample.layers.to"]} }}
seed = {at["sample.seed"]}
[solver]
h = {STEP}
[[walls]]
name = "hanging"
points = {at["walls.hanging.points"]}
motion = {{ stage = "slip", velocity = {at["walls.hanging.motion.velocity"]} }}
[[walls]]
name = "footwall"
points = {at["walls.footwall.points"]}
[[stages]]
name = "slip"
duration = {at["stages.slip.duration"]}
[output]
frames = {{ every = {at["output.frames.every"]} }}
cells = [{{ name = "W1", centre = {at["output.cells.W1.centre"]}, radius = {at["output.cells.W1.radius"]} }}]
[output.zone]
wall = "{at["output.zone.wall"]}"
tip = {at["output.zone.tip"]}
"""


def write_summary(folder, settings, stopped=False):
    steps = round(float(settings["stages.slip.duration"]) / STEP)
    summary = {"scene": scene_text(settings), "steps": steps, "stopped_early": stopped}
    (folder / "summary.json").write_text(json.dumps(summary))


def stand_in(told):
    if told[0] == "restart":
        folder = Path(told[1])
        (folder / "told.json").write_text(json.dumps(told))
        text = (folder / "scene.toml").read_text()
        (folder / "summary.json").write_text(json.dumps({"scene": text, "steps": 20, "stopped_early": False}))
        return
    options = dict(zip(told[2::2], told[3::2]))
    settings = dict(value.split("=", 1) for option, value in zip(told[2::2], told[3::2]) if option == "--set")
    folder = Path(options["--out"])
    first_frame = folder / "frames/frame-00000000.hdf"
    first_frame.parent.mkdir(parents=True, exist_ok=True)
    (folder / "begun").touch()
    (folder / "told.json").write_text(json.dumps(told))
    other = folder.parent / folder.name.replace("gamma0", "gamma1e5") / "begun"
    diary = {"alone": not other.exists()}
    time.sleep(0.5)  # settles; long enough for another run to begin if it may
    diary["alone"] &= not other.exists()
    first_frame.touch()
    deadline = time.monotonic() + float(os.environ["STAND_IN_SECONDS"])
    while not other.exists() and time.monotonic() < deadline:
        time.sleep(0.05)
    diary["together"] = other.exists()
    (folder / "diary.json").write_text(json.dumps(diary))
    if folder.name == os.environ.get("STAND_IN_FAILS"):
        sys.exit("told to fail")
    write_summary(folder, settings)


def make_stand_in(folder):
    path = folder / "nappe-stand-in"
    path.write_text(STAND_IN)
    path.chmod(0o755)
    return path


def test_list(folder):
    """Every combination once; seed after seed, the reference first, the gammas of a sample together; the geometry."""
    printed = run_tool("list", "--out", folder, "--nappe", "some/nappe").splitlines()
    heads = [re.fullmatch(r"# (\d+) (theta(\d+)-h([\d.]+)-gamma(\S+)-seed(\d)): to do", line) for line in printed[::2]]
    assert len(heads) == 108 and all(heads), printed[0]
    keys = {head.group(3, 4, 5, 6) for head in heads}
    wanted = set(itertools.product(("20", "30", "45"), ("10", "15", "22.5"), ("0", "1e3", "1e4", "1e5"), "123"))
    assert keys == wanted, keys ^ wanted
    assert [int(head.group(1)) for head in heads] == [k // 4 for k in range(108)]
    assert [head.group(6) for head in heads] == ["1"] * 36 + ["2"] * 36 + ["3"] * 36
    assert {head.group(3, 4) for head in heads[:4]} == {("30", "15")}
    for first in range(0, 108, 4):
        assert len({head.group(3, 4, 6) for head in heads[first : first + 4]}) == 1

    only = run_tool("list", "--out", folder, "--only", "theta45-h22.5-gamma1e4-seed2").splitlines()
    words = shlex.split(only[1])
    settings = dict(word.split("=", 1) for word in words[words.index("--set") + 1 :: 2])
    tip = json.loads(settings["output.zone.tip"])
    hanging, footwall = (json.loads(settings[f"walls.{name}.points"]) for name in ("hanging", "footwall"))
    velocity = json.loads(settings["walls.hanging.motion.velocity"])
    assert hanging[2] == footwall[0] == tip == [30, 0]
    assert math.isclose(math.hypot(*velocity), 0.325, rel_tol=1e-9) and math.isclose(velocity[0], velocity[1])
    face = [hanging[3][k] - tip[k] for k in (0, 1)]
    assert math.isclose(math.hypot(*face), 16, rel_tol=1e-9)
    assert abs(face[0] * velocity[1] - face[1] * velocity[0]) < 1e-8 and face[1] < 0  # down along the fault
    profile = json.loads(settings["sample.profile"])
    assert profile == [[0, 0], footwall[1], [footwall[1][0], 22.5], [0, 22.5]]
    assert math.isclose(profile[1][0], 30 + 1.35 * 22.5 + 20, rel_tol=1e-9)
    assert float(settings["materials.rock.gamma"]) == 1e4 and settings["sample.seed"] == "2"
    assert "leave no run" in run_tool("list", "--only", "theta31*", code=1)


def test_resume(folder):
    """A run waits for its sample's first; what failed, stopped or has other settings is run again, the rest is not."""
    nappe, out = make_stand_in(folder), folder / "out"
    os.environ["STAND_IN_SECONDS"] = "20"  # at most, of waiting for the other run of the sample
    quick = ("--quick", "--out", out, "--nappe", nappe, "--jobs", 3)
    os.environ["STAND_IN_FAILS"] = "theta45-h3-gamma1e5-seed1"
    printed = run_tool("run", *quick, "--only", "*seed1", code=1)
    assert "1 failed: theta45-h3-gamma1e5-seed1" in printed, printed
    del os.environ["STAND_IN_FAILS"]
    for theta in ("30", "45"):
        diary = json.loads((out / f"theta{theta}-h3-gamma0-seed1/diary.json").read_text())
        assert diary == {"alone": True, "together": True}, (theta, diary)

    # One is done already, one was stopped by a signal, one has the summary of another seed, one failed.
    stopped, other = out / "theta30-h3-gamma0-seed1", out / "theta30-h3-gamma1e5-seed1"
    summary = json.loads((stopped / "summary.json").read_text())
    (stopped / "summary.json").write_text(json.dumps({**summary, "stopped_early": True}))
    summary = json.loads((other / "summary.json").read_text())
    assert "seed = 1\n" in summary["scene"]
    summary["scene"] = summary["scene"].replace("seed = 1\n", "seed = 7\n")
    (other / "summary.json").write_text(json.dumps(summary))
    printed = run_tool("list", "--quick", "--out", out, "--only", "*seed1")
    assert re.findall(r"(\S+): done", printed) == ["theta45-h3-gamma0-seed1"], printed
    printed = run_tool("run", *quick, "--only", "*seed1")
    again = sorted(re.findall(r"(\S+): begun", printed))
    assert again == ["theta30-h3-gamma0-seed1", "theta30-h3-gamma1e5-seed1", "theta45-h3-gamma1e5-seed1"], printed
    assert "4 of 4 runs are done" in run_tool("run", *quick, "--only", "*seed1")
    printed = run_tool("run", *quick, "--index", 3)  # a Slurm array's way: one sample
    assert sorted(re.findall(r"(\S+): begun", printed)) == ["theta45-h3-gamma0-seed2", "theta45-h3-gamma1e5-seed2"]


def test_restart(folder):
    """What an earlier attempt of the same run left goes on; what one with other settings left is overwritten."""
    nappe, out = make_stand_in(folder), folder / "out"
    os.environ["STAND_IN_SECONDS"] = "0"
    same, other = (run for run in plan.QUICK.runs() if run.theta == 30 and run.seed == 1)
    for run in (same, other):
        left = out / run.name
        settings = {key: plan.toml(value) for key, value in run.settings().items()}
        if run is other:
            settings["sample.seed"] = "7"
        for file in ("checkpoints/checkpoint-00000010.json", "frames/frame-00000000.hdf", "scene.toml"):
            (left / file).parent.mkdir(parents=True, exist_ok=True)
            (left / file).write_text(scene_text(settings))
    first_frame = out / same.name / "frames/frame-00000000.hdf"
    written = first_frame.stat().st_mtime_ns
    printed = run_tool("run", "--quick", "--out", out, "--nappe", nappe, "--only", "theta30-*-seed1")
    assert "failed" not in printed, printed
    assert json.loads((out / same.name / "told.json").read_text()) == ["restart", str(out / same.name)]
    assert first_frame.stat().st_mtime_ns == written, "the first frame of a run that goes on is a result of its own"
    told = json.loads((out / other.name / "told.json").read_text())
    assert told[0] == "run" and told.count("--overwrite") == 1, told
    assert "2 of 2 runs are done" in run_tool("run", "--quick", "--out", out, "--only", "theta30-*-seed1")

    settling = next(run for run in plan.QUICK.runs() if run.theta == 45)  # there is no scene yet
    (out / settling.name / "checkpoints").mkdir(parents=True)
    (out / settling.name / "checkpoints/checkpoint-000001.json").touch()
    run_tool("run", "--quick", "--out", out, "--nappe", nappe, "--only", settling.name, code=1)  # the stand-in has none
    assert json.loads((out / settling.name / "told.json").read_text())[0] == "restart"


def test_stop(folder):
    """USR1, as a batch system sends it, ends what runs and begins nothing; exit code 3."""
    nappe, out = make_stand_in(folder), folder / "out"
    os.environ["STAND_IN_SECONDS"] = "60"
    command = [TOOL, "run", "--quick", "--jobs", "1", "--out", out, "--nappe", nappe]
    study = subprocess.Popen(list(map(str, command)), stdout=subprocess.PIPE, text=True)
    try:
        while "begun" not in study.stdout.readline():
            assert study.poll() is None
        study.send_signal(signal.SIGUSR1)
        printed, _ = study.communicate(timeout=30)
    finally:
        study.kill()
    assert study.returncode == 3 and "begun" not in printed, (study.returncode, printed)
    assert not list(out.glob("*/summary.json"))


def left_limit(run, results_of):
    """What the made-up left limits follow [°]: falls with the logarithm of the cohesion over the column's weight."""
    return 40 + 30 * math.tan(math.radians(run.theta)) - 12 * math.log10(1 + results_of(run) / 0.1)


def by_column(run):
    return run.gamma / (2800 * 9.81 * run.height * 0.39)


def write_results(folder, noise):
    """All runs of the study, their left limits by the formula and some noise, their residuals noise alone; one front
    runs against the end of the box."""
    rng = np.random.default_rng(4)
    for run in plan.FULL.runs():
        out = folder / run.name
        out.mkdir(parents=True)
        write_summary(out, {key: plan.toml(value) for key, value in run.settings().items()})
        theta, tip = math.radians(run.theta), run.tip
        left = left_limit(run, by_column) + noise * rng.standard_normal()
        residual = 0.2 + 0.01 * rng.standard_normal()
        far = run.name == "theta20-h10-gamma0-seed2"
        front = run.length - 1 if far else run.surface_point + 0.5 * run.height
        values = made_up_measures.zone_values(theta, tip, half_angle=math.radians(HALF_ANGLE), residual=residual)
        values |= {"left_angle": math.radians(left), "opening": math.radians(left - run.theta + HALF_ANGLE)}
        steps = [(step, step * STEP) for step in range(0, 4001, 400)]
        zones = [(step, t, values if step else {"left_points": 0}) for step, t in steps]  # nothing to fit at rest
        fronts = [(step, t, {"front": front}) for step, t in steps]
        made_up_measures.write_table(out / "measures/zone.csv", made_up_measures.ZONE, zones)
        made_up_measures.write_table(out / "measures/surface.csv", made_up_measures.SURFACE, fronts)


def test_report(folder):
    """Finds the relation that the made-up results follow, with its coefficients, and none where there is none."""
    noise = 0.8  # degrees
    write_results(folder, noise)
    run_tool("report", "--out", folder, "--pictures", folder / "pictures")
    text, data = (folder / "report.md").read_text(), json.loads((folder / "report.json").read_text())
    assert "108 of 108 runs" in text and len(data["runs"]) == 108
    one = next(run for run in data["runs"] if run["name"] == "theta30-h15-gamma1e4-seed1")
    # A grain of mean weight: the mean of r² over [0.13, 0.26] m is 0.03943 m².
    assert math.isclose(one["by_grain"], 1e4 / (2800 * 9.81 * math.pi * 0.0394333333), rel_tol=1e-6), one
    assert math.isclose(one["front0"], 0.5, rel_tol=1e-9) and math.isclose(one["apical"], HALF_ANGLE, rel_tol=1e-9)

    fits = {fit["outcome"]: fit for fit in data["fits"]}
    left = fits["left"]
    # The pooled deviation has 72 degrees of freedom: it is known to 1 / sqrt(144), and 4 of those hold always.
    assert abs(left["scatter"] / noise - 1) < 4 / 12, left["scatter"]
    assert left["supported"] and left["best"] == "e log(1 + C / u0)", left
    best = next(relation for relation in left["relations"] if relation["name"] == left["best"])
    # The slope in tan(dip), which varies by 0.26, is uncertain by 0.8 / (0.26 sqrt(108)); that in the decades of C by
    # about as much of 12 as u0 is uncertain: a third.
    assert abs(best["coefficients"][1] - 30) < 4 * noise / (0.26 * math.sqrt(108)), best
    assert abs(best["coefficients"][3] + 12) < 4 and 0.04 < best["u0"] < 0.25, best
    assert not fits["residual"]["supported"], fits["residual"]
    # The made-up half angle does not depend on cohesion, so nothing is fitted to it; to points on a curve the curve is.
    assert data["zone"] == []
    grains = [0.3, 3.0, 10.0, 30.0]
    found = fits_module.weakening(grains, [1 - 0.8 * u / (u + 10) for u in grains])
    # u0 is sought on a grid that holds 10.
    assert math.isclose(found.u0, 10, rel_tol=1e-9) and math.isclose(found.c, 0.8, rel_tol=1e-9) and found.r2 > 1 - 1e-9
    assert fits_module.weakening(grains, [0.9] * 4) is None
    assert "## What cohesion changes" in text and " *" in text
    assert "| trishear residual inside the zone |" in text and text.count("| none |") >= 1

    near = [run["name"] for run in data["runs"] if run["too_near"]]
    assert near == ["theta20-h10-gamma0-seed2"] and f"- {near[0]}: front from a slip of" in text
    for name in ("limits", "trishear", "front", "relations"):
        path = folder / "pictures" / f"fault-study-{name}.png"
        assert path.stat().st_size > 10000, path
        assert f"(pictures/{path.name})" in text

    # A relation that is there, but explains a third of the variance, is not said to be supported.
    found = [results.read(run, folder) for run in plan.FULL.runs()]
    differences = report.paired(found)[(45, 1e5)]["left"]
    runs = {(run.height, run.gamma): run for run in plan.FULL.runs() if run.theta == 45}
    formula = [left_limit(runs[h, 1e5], by_column) - left_limit(runs[h, 0.0], by_column) for h in (10, 15, 22.5)]
    assert len(differences) == 9
    # Nine differences of two values with that noise each.
    assert abs(sum(differences) / 9 - sum(formula) / 3) < 4 * noise * math.sqrt(2 / 9), differences
    rng = np.random.default_rng(5)
    part = np.array([math.log10(1 + by_column(result.run) / 0.1) for result in found])
    part = part / part.std() + math.sqrt(2) * rng.standard_normal(len(found))
    for result, value in zip(found, part):
        result.figures["left"] = float(value)
    weak = Study(next(one for one in results.OUTCOMES if one.key == "left"), found)
    assert weak.best.rms_foretold < 0.9 * weak.candidates[0].rms_foretold and not weak.supported


def test_program(folder):
    """The small study by nappe itself, from the first run to the report."""
    quick = ("--quick", "--only", "theta30-*-seed1", "--out", folder, "--nappe", NAPPE)
    run_tool("run", *quick)
    assert "2 of 2 runs are done" in run_tool("run", *quick)
    assert len(list((folder / "samples").glob("*.hdf"))) == 1, "the two cohesions do not share their sample"
    run_tool("measure", *quick)
    assert "2 of 2 finished runs are measured" in run_tool("measure", *quick)
    run_tool("report", *quick)
    assert "2 of 2 runs" in (folder / "report.md").read_text()


def test_table(folder):
    """Figures of one made-up run of the reference scene, each in its own unit."""
    out = folder / "run"
    times = [(step, step / 100) for step in range(0, 4001, 200)]
    zone = made_up_measures.zone_values(math.radians(30), (75, 0), half_angle=math.radians(12), s=1.0, residual=0.05)
    outcrop = 75 + 15 / math.tan(math.radians(30))
    surface = {"front": outcrop + 8, "slope": math.radians(25), "curvature": -0.1}
    tables = {
        "measures/zone": (made_up_measures.ZONE, zone),
        "measures/surface": (made_up_measures.SURFACE, surface),
        "series/cell-W1": (["p", "q", "lambda_x", "lambda_y"], {"p": 2e5, "q": 5e4, "lambda_x": 1.4, "lambda_y": 1.5}),
        "series/energy": (
            ["wall_work", "friction", "impact", "cohesion", "error"],
            {"wall_work": 2e8, "friction": 2e7, "impact": 3e6, "cohesion": 1e6, "error": 2.0},
        ),
        "series/solver": (["residual"], {"residual": 0.1}),
    }
    for name, (columns, values) in tables.items():
        made_up_measures.write_table(out / f"{name}.csv", columns, [(step, t, values) for step, t in times])
    scene = plan.SCENE.read_text().replace("gamma = 0.0", "gamma = 1e4")
    summary = {"scene": scene, "overlap_mean": 0.001, "overlap_max_of_rows": 0.1, "state_hash": "ab"}
    (out / "summary.json").write_text(json.dumps(summary))
    of_fields, reference._of_fields = reference._of_fields, lambda run, height: (0.04, 5.0)
    try:
        rows = dict(reference.figures(reference.Run(out)))
    finally:
        reference._of_fields = of_fields
    expected = {
        "γ over a grain's weight": "2.9",
        "front beyond the fault's outcrop at 20 s, 40 s [m]": "8.0, 8.0",
        "slope of the surface at 40 s [°]": "25",
        "left limit [°]": "42 ± 0",
        "right limit [°]": "18 ± 0",
        "opening [°]": "24 ± 0",
        "trishear: half apical angle [°]": "12 ± 0",
        "trishear: late frames with s, with the tip at a bound": "11, 0 of 11",
        "p in W1, means over 0–10, 10–20, 20–30, 30–40 s [kPa]": "200, 200, 200, 200",
        "lost to friction, impact, cohesion by 40 s [MJ/m]": "20.00, 3.00, 1.00",
        "error of the energy balance / work of walls": "1e-08",
    }
    assert {name: rows[name] for name in expected} == expected, rows
    # No column of docs/fault.md is of another version of the table.
    page = (plan.SCENE.parents[1] / "docs" / "fault.md").read_text()
    assert [name for name in rows if f"| {name} |" not in page] == []


TESTS = {
    "table": test_table,
    "list": test_list,
    "resume": test_resume,
    "restart": test_restart,
    "stop": test_stop,
    "report": test_report,
    "program": test_program,
}

if __name__ == "__main__":
    for name in sys.argv[4:] or TESTS:
        shutil.rmtree(FOLDER / name, ignore_errors=True)
        (FOLDER / name).mkdir(parents=True)
        TESTS[name](FOLDER / name)
        print(f"{name}: as it should be")
