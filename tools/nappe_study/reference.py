"""The figures of some runs of the fault scene side by side, as docs/fault.md quotes them."""

import json
import math
import tomllib

import numpy as np
from nappe_plot import fault, fields, tables

from .results import mean_grain_area

LATE = (20.0, 40.0)  # s: the zone is formed, the surface flows
PHASES = ((0, 10), (10, 20), (20, 30), (30, 40))  # s, those that the seed speaks of


class Run:
    def __init__(self, folder):
        self.folder = folder
        try:
            self.summary = json.loads((folder / "summary.json").read_text())
        except (OSError, json.JSONDecodeError) as error:
            raise SystemExit(f"fault_study: {folder} holds no finished run ({error}); name folders that nappe run has made")
        self.scene = tomllib.loads(self.summary["scene"])
        self.gamma = float(self.scene["materials"]["rock"]["gamma"])

    def table(self, name):
        """Of measures/NAME.csv or series/NAME.csv."""
        found = tables.read(self.folder / f"{name}.csv")
        if found is None:
            raise SystemExit(f"fault_study: {self.folder}/{name}.csv is missing or empty; run nappe measure on it first")
        return found

    def median(self, name, column, span=LATE):
        """With half the range between quartiles."""
        table = self.table(name)
        values = table[column][(table["time"] >= span[0] - 1e-9) & (table["time"] <= span[1] + 1e-9)]
        low, middle, high = np.quantile(values[np.isfinite(values)], (0.25, 0.5, 0.75))
        return middle, (high - low) / 2

    def mean(self, name, column, span):
        """Of a series whose rows are averages over the time before them."""
        table = self.table(name)
        return float(np.mean(table[column][(table["time"] > span[0] + 1e-9) & (table["time"] <= span[1] + 1e-9)]))

    def last(self, name, column):
        return float(self.table(name)[column][-1])


def _of_fields(run, height):
    """From the fields of the late frames: RMS of |v - trishear| / V0 at nodes below the first surface of the bed, and the
    distance along x, at two thirds of the bed, from 75 % to 25 % of V0 [m]."""
    the_fault, zone = fault.of(run), run.table("measures/zone")
    below, widths = [], []
    for row, time in enumerate(zone["time"]):
        if not LATE[0] - 1e-9 <= time <= LATE[1] + 1e-9:
            continue
        field = fields.read(run.folder / f"measures/fields/fields-{int(zone['step'][row]):08}.hdf")
        x, y = np.meshgrid(field.x, field.y)
        fit = {name: values[row] for name, values in zone.items()}
        model = fault.trishear(the_fault, fit, x, y)
        error = np.hypot(*np.moveaxis(field.velocity - model, -1, 0)) / the_fault.speed
        in_bed = np.isfinite(error) & (y < height)
        below.append(np.sqrt(np.mean(error[in_bed] ** 2)))
        level = field.speed[int(np.argmin(abs(field.y - 2 * height / 3)))] / the_fault.speed
        first, last = (np.flatnonzero(level > share)[-1] for share in (0.75, 0.25))
        widths.append(field.x[last] - field.x[first])
    return np.median(below), np.median(widths)


def figures(run):
    """Rows of the table: what, and its value as text."""
    degrees = math.degrees
    zone, surface, cell = "measures/zone", "measures/surface", "series/cell-W1"
    sample, wall = run.scene["sample"], run.scene["output"]["zone"]
    weight = run.scene["materials"]["rock"]["density"] * -run.scene["world"]["gravity"][1]
    height = max(y for _, y in sample["profile"])
    velocity = next(w["motion"]["velocity"] for w in run.scene["walls"] if w["name"] == wall["wall"])
    fault_out = wall["tip"][0] + height * velocity[0] / velocity[1]

    def angle(column):
        middle, spread = run.median(zone, column)
        return f"{degrees(middle):.0f} ± {degrees(spread):.0f}"

    def plain(column, digits):
        middle, spread = run.median(zone, column)
        return f"{middle:.{digits}f} ± {spread:.{digits}f}"

    yield "γ over a grain's weight", f"{run.gamma / (weight * mean_grain_area(sample['radius'])):.2g}"
    yield "front beyond the fault's outcrop at 20 s, 40 s [m]", ", ".join(
        f"{front - fault_out:.1f}" for front in (_at(run.table(surface), "front", t) for t in LATE)
    )
    yield "slope of the surface at 40 s [°]", f"{degrees(run.last(surface, 'slope')):.0f}"
    yield "curvature of the surface at 40 s [1/m]", f"{run.last(surface, 'curvature'):.3f}"
    yield "left limit [°]", angle("left_angle")
    yield "left limit, tolerance halved, doubled [°]", f"{angle('left_angle_half')}, {angle('left_angle_twice')}"
    yield "right limit [°]", angle("right_angle")
    yield "right limit, tolerance halved, doubled [°]", f"{angle('right_angle_half')}, {angle('right_angle_twice')}"
    yield "opening [°]", angle("opening")
    yield "trishear: late frames with s, with the tip at a bound", _at_bounds(run.table(zone), wall["tip"], height)
    yield "trishear: half apical angle [°]", angle("trishear_half_angle")
    yield "trishear: s", plain("trishear_s", 2)
    yield "trishear: residual / V0", plain("trishear_residual", 3)
    below, width = _of_fields(run, height)
    yield "trishear: residual inside the model's zone", plain("trishear_residual_inside", 3)
    yield "trishear: residual below the bed's first surface", f"{below:.3f}"
    yield "from 75 % to 25 % of V0 along x, at 2/3 of the bed [m]", f"{width:.1f}"
    for name, column in (("p", "p"), ("q", "q")):
        means = ", ".join(f"{run.mean(cell, column, span) / 1e3:.0f}" for span in PHASES)
        yield f"{name} in W1, means over 0–10, 10–20, 20–30, 30–40 s [kPa]", means
    lambda_x = run.table(cell)
    lowest = int(np.argmin(lambda_x["lambda_x"]))
    yield "λ_x: least (when), at 40 s", (
        f"{lambda_x['lambda_x'][lowest]:.2f} ({lambda_x['time'][lowest]:.0f} s), {run.last(cell, 'lambda_x'):.2f}"
    )
    ys = [_at(lambda_x, "lambda_y", t) for t in (10, 20, 40)]
    yield "λ_y at 10, 20, 40 s", ", ".join(f"{y:.2f}" for y in ys)
    blocks_title = "bonds broken at 40 s; detached blocks; grains without a bond of theirs"
    if (run.folder / "measures" / "blocks.csv").exists():
        blocks = run.table("measures/blocks")
        last = {name: values[-1] for name, values in blocks.items()}
        yield blocks_title, (
            f"{100 * (1 - last['intact']):.1f} %; {last['detached']:.0f} ({last['detached_grains']:.0f} grains); "
            f"{last['single']:.0f}"
        )
    else:
        yield blocks_title, "–"
    energy = run.table("series/energy")
    losses = [energy[k][-1] / 1e6 for k in ("friction", "impact", "cohesion")]
    yield "lost to friction, impact, cohesion by 40 s [MJ/m]", ", ".join(f"{loss:.2f}" for loss in losses)
    yield "error of the energy balance / work of walls", f"{abs(energy['error'][-1] / energy['wall_work'][-1]):.0e}"
    yield "overlap / r: mean at 40 s, largest of all rows", (
        f"{run.summary['overlap_mean']:.4f}, {run.summary['overlap_max_of_rows']:.2f}"
    )
    solver = run.table("series/solver")
    yield "residual: median of rows", f"{np.nanmedian(solver['residual']):.2f}"
    yield "state hash", f"`{run.summary['state_hash']}`"


def _at(table, column, time):
    return float(table[column][np.argmin(np.abs(table["time"] - time))])


def _at_bounds(zone, tip, height):
    """The fit's bounds are those of docs/measures.md: s in [1, 20], the tip within two thicknesses of the bed."""
    late = (zone["time"] >= LATE[0] - 1e-9) & (zone["time"] <= LATE[1] + 1e-9)
    s, reach = zone["trishear_s"][late], 2 * height
    away = np.maximum(abs(zone["trishear_x"][late] - tip[0]), abs(zone["trishear_y"][late] - tip[1]))
    return f"{np.sum((s < 1.001) | (s > 19.9))}, {np.sum(away > 0.999 * reach)} of {np.sum(late)}"


def markdown(folders):
    """One column a run, in the order given."""
    runs = [Run(folder) for folder in folders]
    columns = [list(figures(run)) for run in runs]
    lines = ["| | " + " | ".join(f"γ = {run.gamma:g} N" for run in runs) + " |", "| --- |" + " --- |" * len(runs)]
    for rows in zip(*columns, strict=True):
        lines.append(f"| {rows[0][0]} | " + " | ".join(value for _, value in rows) + " |")
    return "\n".join(lines)
