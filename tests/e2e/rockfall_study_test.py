"""tools/rockfall_study: every run it plans is a sound scene, its figures follow from series that are made up, its tables find
their places in the page.

Usage: python3 rockfall_study_test.py ROOT_OF_THE_REPOSITORY NAPPE FOLDER, with a Python that has matplotlib."""

import json
import math
import re
import shutil
import subprocess
import sys
from pathlib import Path

import numpy as np

ROOT, NAPPE, FOLDER = Path(sys.argv[1]).resolve(), Path(sys.argv[2]), Path(sys.argv[3]).resolve()
sys.path.insert(0, str(ROOT / "tools"))

from nappe_rockfall import plan, report  # noqa: E402
from nappe_rockfall.results import Result  # noqa: E402

WEIGHT, FORCE, MASS, SPEED = 9000.0, 60000.0, 3500 * math.pi * 0.3**2, 14.0071


def write(path, columns):
    rows = zip(*columns.values())
    path.write_text("\n".join([",".join(columns), *(",".join(f"{value!r}" for value in row) for row in rows)]) + "\n")


def made_up(folder, shift=0):
    """A run of 0.2 s with a row each 0.1 ms: 3 m of slab bear WEIGHT, and FORCE more from 10 to 20 ms (later by shift), P1
    twice the mean but in one row of its own; the rock goes down 5 cm and up again 8."""
    series = folder / "series"
    series.mkdir(parents=True)
    time = np.round(1e-4 * np.arange(2001), 10)
    force = WEIGHT + FORCE * ((time > 0.01 + shift + 1e-9) & (time < 0.02 + shift + 1e-9))
    bins = {f"{part}_{k}": force / 3 * (part == "normal") for k in range(15) for part in ("normal", "tangential")}
    write(series / "gauge-slab.csv", {"step": time / 1e-4, "time": time} | bins)
    for k in range(1, 6):
        pressure = 2 * force / 3 / k
        pressure[151] *= 3
        write(series / f"gauge-P{k}.csv", {"time": time, "normal_0": pressure, "tangential_0": 0 * time})
    depth = np.interp(time, [0, 0.02, 0.1, 0.2], [0, 0.05, -0.03, 0])
    write(series / "probe-block.csv", {"time": time, "vy": 0 * time - SPEED, "penetration": depth})
    write(series / "solver.csv", {"time": time[::1000], "overlap_max": [0.1, 0.62, 0.02]})
    write(series / "energy.csv", {"time": time, "friction": 3 * time, "dashpot": 0 * time, "damping": time})
    scene = (ROOT / "jobs/rockfall-0.5-10-c.toml").read_text()
    figures = {"scene": scene, "steps": 7, "seconds_loading": 3.0}
    (folder / "summary.json").write_text(json.dumps(figures))
    (folder / "said.txt").write_text("exit code 0\n")
    return Result(folder)


def check_plan():
    runs = plan.planned()
    assert len({one.name for one in runs}) == len(runs), "two runs share a folder"
    kinds = {(one.job, *one.keys): one for one in runs}  # other seeds are other values of the same keys
    for one in kinds.values():
        sets = [word for key, value in one.keys.items() for word in ("--set", f"{key}={value}")]
        done = subprocess.run([NAPPE, "check", one.scene, *sets], capture_output=True, text=True)
        assert done.returncode == 0, (one.name, done.stderr)
        # Rows of gauges and probes lie equally far apart in all runs, or means over them could not be compared.
        assert len(set(re.findall(r"^(?:gauge|probe).* steps, (.*)$", done.stdout, re.M))) == 1, done.stdout
        assert "0.0001 s" in done.stdout, (one.name, done.stdout)


def check_figures():
    one = made_up(FOLDER / "0.5-10-c")
    high = 2e-3 * (WEIGHT + FORCE) / 3
    assert np.allclose(one.pressure("P1"), (3 * high, 0.0151)), one.pressure("P1")
    assert np.allclose(one.pressure("P1", 1e-3)[0], high * 1.2), "one of ten rows is three times as high"
    assert np.allclose(one.pressure("P2", 5e-3)[0], high / 2 * 1.04)
    assert abs(one.pressure("P1", 1e-3)[1] - 0.0151) < 5.1e-4, "the middle of an interval that holds the row"
    assert np.allclose(one.slab_force(1e-3)[0], (WEIGHT + FORCE) / 1e3)
    assert math.isclose(one.momentum_to_slab(), FORCE * 0.01 / (MASS * SPEED), rel_tol=1e-9), one.momentum_to_slab()
    assert np.allclose(one.penetration(), (0.05, 0.02, 0)) and np.allclose(one.apogee(), (0.03, 0.1))
    assert np.allclose(one.rebound(), 0.08)
    assert np.allclose([one.losses()[name] for name in ("friction", "dashpot", "damping")], (0.75, 0, 0.25))

    results = {"0.5-10-c": one, "0.5-10-c-seed2": made_up(FOLDER / "0.5-10-c-seed2", shift=0.001)}
    results |= {"0.5-10-b": made_up(FOLDER / "0.5-10-b", shift=0.002)}
    made = report.tables(results)
    assert any(line.startswith("| 0.5-10-b | 5.0 | 0.020 | 8.0 | 138 at 15.1 | 69 at 15.1 ") for line in made["runs"]), made["runs"]
    assert any(line.endswith(" | 0.62 | 7 |") for line in made["runs"]), "the largest overlap of all rows, not the last one"
    assert any("| P1, c over b | 1 | 1 " in line for line in made["ratios"]), made["ratios"]
    assert any(line.startswith("| 0.5-10-c, 2 samples | 5 ± 0 (5 to 5) ") for line in made["rigid"]), made["rigid"]
    for lines in made.values():
        assert len({line.count("|") for line in lines}) == 1, lines

    failed = FOLDER / "0.5-10-b" / "said.txt"
    failed.write_text("nappe: the centre of grain 5 went through wall 'slab' in step 9\nexit code 4\n")
    late = report.runs({"0.5-10-b": Result(FOLDER / "0.5-10-b")})
    assert "unstable" not in late[-1], "what failed after the figures were taken still has them"
    assert report.spread([1, 2, 3]) == "2 ± 1 (1 to 3)" and report.number(1234.5) == "1,230"


def check_page():
    page = (ROOT / "docs/rockfall.md").read_text()
    assert re.findall(r"<!-- table (\w+) -->", page) == list(report.TABLES), "the page has a place for every table"
    put = report.put_into(page, {"runs": ["| a |"], "rigid": ["| b \\1 |"]})
    assert "<!-- table runs -->\n| a |\n<!-- end -->" in put and "<!-- table rigid -->\n| b \\1 |\n<!-- end -->" in put
    assert report.put_into(put, {"runs": [], "rigid": []}).count("<!-- end -->") == page.count("<!-- end -->")
    try:
        report.put_into("nothing here", {"runs": []})
        raise AssertionError("a page without places was taken")
    except SystemExit as error:
        assert "table runs" in str(error)
    missing = [name for name in re.findall(r"\((pictures/[^)]+)\)", page) if not (ROOT / "docs" / name).exists()]
    assert not missing, missing


shutil.rmtree(FOLDER, ignore_errors=True)
check_plan()
check_figures()
check_page()
print("planned runs are sound, figures and tables are right")
