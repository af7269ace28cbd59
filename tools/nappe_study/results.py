"""What each run of the study gave: its summary, and figures from its measures."""

import dataclasses
import json
import math
import tomllib

import numpy as np
from nappe_plot import tables

from .plan import SPEED

# Where a run's figures are taken: slip over height. Beds of all heights get there, and the zone is formed by then.
SLIPS = (0.25, 0.55)
FRONT_SLIPS = (0.25, 0.4, 0.55)
MARGIN = 2.0  # m that the zone must keep from either end: five mean diameters


@dataclasses.dataclass(frozen=True)
class Outcome:
    """A figure of a run: its name in tables and fits, and how it is read there."""

    key: str
    title: str
    unit: str
    digits: int


OUTCOMES = [
    Outcome("left", "left limit", "°", 1),
    Outcome("right", "right limit", "°", 1),
    Outcome("opening", "opening", "°", 1),
    Outcome("apical", "trishear half angle", "°", 1),
    Outcome("s", "trishear s", "", 2),
    Outcome("residual", "trishear residual inside the zone", "", 3),
    *(Outcome(f"front{k}", f"front at slip {slip:g} h", "h", 2) for k, slip in enumerate(FRONT_SLIPS)),
]


def summary_of(run, out):
    """The run's summary, or {} while there is none."""
    try:
        return json.loads((out / run.name / "summary.json").read_text())
    except (OSError, json.JSONDecodeError):
        return {}


def is_done(run, out):
    return run.is_done(summary_of(run, out))


def has_checkpoints(run, out):
    return any((out / run.name / "checkpoints").glob("*.json"))


def can_go_on(run, out):
    """Whether an attempt of this very run, stopped or killed, left a checkpoint. While the sample settles the folder does
    not say of which settings it is; should it be of others, the summary at the end will."""
    if not has_checkpoints(run, out):
        return False
    try:
        return run.is_scene(tomllib.loads((out / run.name / "scene.toml").read_text()))
    except FileNotFoundError:
        return True
    except (OSError, tomllib.TOMLDecodeError):
        return False


def is_measured(run, out):
    """Whether the last row of both tables is of the run's last step."""
    steps = summary_of(run, out).get("steps")
    found = [tables.read(out / run.name / "measures" / f"{name}.csv") for name in ("zone", "surface")]
    return steps is not None and all(table is not None and table["step"][-1] == steps for table in found)


def mean_grain_area(radii):
    """Mean weight [N per metre of depth] over density and gravity is the mean of pi r²; radii uniform in [min, max]."""
    low, high = radii["min"], radii["max"]
    return math.pi * (low * low + low * high + high * high) / 3


@dataclasses.dataclass
class Result:
    """A run with its figures by Outcome.key, and its cohesion over the two weights."""

    run: object
    figures: dict
    by_grain: float  # gamma / mean weight of a grain
    by_column: float  # gamma / weight of a column as high as the bed and as wide as a mean grain
    diameters: float  # height of the bed over mean diameter
    too_near: list  # what came nearer than MARGIN to an end of the box, and at which slip


def _median(table, column, rows):
    values = table[column][rows]
    values = values[np.isfinite(values)]
    return float(np.median(values)) if len(values) else math.nan


def read(run, out):
    """Of a run that is done and measured. Medians over the frames between SLIPS: one frame scatters with avalanches."""
    scene = run.scene_of(summary_of(run, out))
    zone, surface = (tables.read(out / run.name / "measures" / f"{name}.csv") for name in ("zone", "surface"))
    slip = SPEED * zone["time"] / run.height
    rows = (slip >= SLIPS[0] - 1e-9) & (slip <= SLIPS[1] + 1e-9)
    figures = {
        "left": math.degrees(_median(zone, "left_angle", rows)),
        "right": math.degrees(_median(zone, "right_angle", rows)),
        "opening": math.degrees(_median(zone, "opening", rows)),
        "apical": math.degrees(_median(zone, "trishear_half_angle", rows)),
        "s": _median(zone, "trishear_s", rows),
        "residual": _median(zone, "trishear_residual_inside", rows),
    }
    known = np.isfinite(surface["front"])
    beyond = (surface["front"] - run.surface_point) / run.height
    for k, wanted in enumerate(FRONT_SLIPS):
        # Between frames the front is taken to move evenly; a run that ended before has no figure.
        times, values = SPEED * surface["time"][known] / run.height, beyond[known]
        reached = len(times) > 0 and times[-1] >= wanted - 1e-9
        figures[f"front{k}"] = float(np.interp(wanted, times, values)) if reached else math.nan
    weight = scene["materials"]["rock"]["density"] * -scene["world"]["gravity"][1]  # N/m³
    radii = scene["sample"]["radius"]
    diameter = radii["min"] + radii["max"]
    return Result(
        run,
        figures,
        run.gamma / (weight * mean_grain_area(radii)),
        run.gamma / (weight * run.height * diameter),
        run.height / diameter,
        _too_near(run, zone, surface),
    )


def _too_near(run, zone, surface):
    """Limits where they meet the surface beside them, and the front, against the ends; in the rows that figures use."""
    found = []
    slip = SPEED * zone["time"]
    used = slip <= SLIPS[1] * run.height + 1e-9
    back = slip * run.direction[0]
    left = zone["left_x"] + (run.height + slip * run.direction[1]) / np.tan(zone["left_angle"])
    right = zone["right_x"] + run.height / np.tan(zone["right_angle"])
    fronts = np.interp(zone["time"], surface["time"], surface["front"])
    for name, near in (
        ("left limit", left < back + MARGIN),
        ("right limit", right > run.length - MARGIN),
        ("front", fronts > run.length - MARGIN),
    ):
        rows = np.flatnonzero(near & used)
        if len(rows):
            found.append(f"{name} from a slip of {slip[rows[0]]:.1f} m on")
    return found
