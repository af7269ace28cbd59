"""Measures as `nappe measure` lays them out, of a flow that is known: the trishear model itself.

make(folder) adds them to a finished run with a wall that moves, and a fault (output.zone) to its scene. So tests of the
pictures and of the study's report know what these must show, and need no run of minutes."""

import json
import math
import tomllib
from pathlib import Path

import h5py
import numpy as np

HALF_ANGLE = math.radians(20)
CONCENTRATION = 1.5
ZONE = (
    "left_x left_angle left_residual left_points right_x right_angle right_residual right_points opening trishear_x "
    "trishear_y trishear_half_angle trishear_s trishear_residual trishear_residual_inside left_angle_half "
    "right_angle_half left_angle_twice right_angle_twice"
).split()
SURFACE = "front crest slope slope_residual curvature".split()


def write_table(path, columns, rows):
    """rows: (step, time, {column: value}); what is not said is nan."""
    path.parent.mkdir(parents=True, exist_ok=True)
    lines = [",".join(["step", "time", *columns])]
    for step, time, values in rows:
        lines.append(",".join([str(step), repr(float(time)), *(repr(float(values.get(c, math.nan))) for c in columns)]))
    path.write_text("\n".join(lines) + "\n")


def zone_values(theta, tip, half_angle=HALF_ANGLE, s=CONCENTRATION, residual=0.0):
    """Of a trishear zone of a fault that dips by theta [rad]: both limits leave the tip, the fault midway between."""
    left, right = theta + half_angle, theta - half_angle
    return {
        "left_x": tip[0], "left_angle": left, "left_residual": 0.0, "left_points": 9,
        "right_x": tip[0], "right_angle": right, "right_residual": 0.0, "right_points": 9,
        "opening": left - right, "trishear_x": tip[0], "trishear_y": tip[1], "trishear_half_angle": half_angle,
        "trishear_s": s, "trishear_residual": residual, "trishear_residual_inside": residual,
        "left_angle_half": left, "right_angle_half": right, "left_angle_twice": left, "right_angle_twice": right,
    }  # fmt: skip


def write_field(path, x, y, velocity, inside, shear_rate, shear_strain):
    """VTKHDF ImageData on the nodes x (nx), y (ny) in two equal layers, as nappe writes it; arrays (ny, nx[, 2]); NaN
    where not inside."""
    path.parent.mkdir(parents=True, exist_ok=True)
    with h5py.File(path, "w") as file:
        image = file.create_group("VTKHDF")
        image.attrs["Version"] = np.array([1, 0])
        image.attrs["Type"] = np.bytes_("ImageData")
        image.attrs["WholeExtent"] = np.array([0, len(x) - 1, 0, len(y) - 1, 0, 1])
        image.attrs["Origin"] = np.array([x[0], y[0], -1.0])
        image.attrs["Spacing"] = np.array([x[1] - x[0], y[1] - y[0], 1.0])
        image.attrs["Direction"] = np.eye(3).ravel()
        space = np.concatenate([velocity, np.zeros_like(velocity[..., :1])], axis=-1)
        fields = {"velocity": space, "shear_rate": shear_rate, "shear_strain": shear_strain}
        for name, values in fields.items():
            values = np.where(inside[..., None] if values.ndim == 3 else inside, values, np.nan)
            image[f"PointData/{name}"] = np.stack([values, values])
        image["PointData/solid_fraction"] = np.stack([np.where(inside, 0.82, 0.0)] * 2)


def add_fault(folder, wall, tip, velocity):
    """Gives the scene of the run's summary a fault: the table output.zone, and the wall's velocity."""
    path = Path(folder) / "summary.json"
    summary = json.loads(path.read_text())
    scene = tomllib.loads(summary["scene"])
    before = next(w for w in scene["walls"] if w["name"] == wall)["motion"]["velocity"]
    shown = "velocity = [ " + ", ".join(repr(float(v)) for v in before) + " ]"
    assert summary["scene"].count(shown) == 1, (shown, summary["scene"])
    said = "velocity = [ " + ", ".join(repr(float(v)) for v in velocity) + " ]"
    summary["scene"] = summary["scene"].replace(shown, said)
    summary["scene"] += f"\n[output.zone]\nwall = '{wall}'\ntip = [ {float(tip[0])}, {float(tip[1])} ]\n"
    path.write_text(json.dumps(summary))


def make(folder, model, theta, tip, spacing):
    """Writes DIR/measures for every frame: the field `model(x, y)` -> (…, 2) [m/s] below the surface, its zone."""
    from nappe_plot.run import Run

    run = Run(folder)
    zones, surfaces, strain = [], [], 0.0
    for index, path in enumerate(run.frame_paths):
        frame = run.frame(index)
        low, high = frame.x.min(axis=0), frame.x.max(axis=0)
        x, y = (np.arange(low[k], high[k] + spacing, spacing) for k in (0, 1))
        column = np.clip(((frame.x[:, 0] - low[0]) / spacing).astype(int), 0, len(x) - 1)
        surface = np.full(len(x), low[1])
        np.maximum.at(surface, column, frame.x[:, 1])
        inside = y[:, None] < surface
        velocity = model(*np.meshgrid(x, y))
        shear = abs(np.gradient(velocity[..., 0], spacing, axis=0) + np.gradient(velocity[..., 1], spacing, axis=1))
        elapsed = frame.time - (run.times[index - 1] if index else frame.time)
        # The grid follows the grains' extent: strain is kept where grids of two frames have the same nodes.
        strain = (strain if np.shape(strain) == shear.shape else np.zeros_like(shear)) + shear * elapsed
        measures = run.folder / "measures"
        write_field(measures / "fields" / path.name.replace("frame-", "fields-"), x, y, velocity, inside, shear, strain)
        zones.append((frame.step, frame.time, zone_values(theta, tip)))
        surfaces.append((frame.step, frame.time, {"front": tip[0] + 2 * high[1], "crest": high[1]}))
    write_table(measures / "zone.csv", ZONE, zones)
    write_table(measures / "surface.csv", SURFACE, surfaces)
