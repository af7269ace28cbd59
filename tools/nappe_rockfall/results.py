"""What a run's folder says of the impact."""

import json
import math
import tomllib

import numpy as np

from nappe_plot import tables

LOSSES = ["friction", "dashpot", "damping", "impact"]
UNTIL = 0.08  # s: what the report's figures of pressures show


def peak(time, values):
    """Largest value and when it was first reached."""
    k = int(np.argmax(values))
    return float(values[k]), float(time[k])


class Result:
    def __init__(self, folder):
        self.folder = folder
        self.summary = json.loads((folder / "summary.json").read_text()) if (folder / "summary.json").exists() else None
        self.said = (folder / "said.txt").read_text() if (folder / "said.txt").exists() else ""
        self.probe = tables.read(folder / "series" / "probe-block.csv")
        self.solver = tables.read(folder / "series" / "solver.csv")
        self.energy = tables.read(folder / "series" / "energy.csv")
        self.gauges = {f"P{k}": tables.read(folder / "series" / f"gauge-P{k}.csv") for k in range(1, 6)}
        self._slab = tables.read(folder / "series" / "gauge-slab.csv")

    @property
    def failed(self):
        """Ended by a numerical failure."""
        return "exit code 4" in self.said

    @property
    def reason(self):
        """Of a failure."""
        lines = [line for line in self.said.splitlines() if line.startswith("nappe: ")]
        return lines[-1][7:] if lines else "no reason"

    @property
    def end(self):
        """Of the run, or of what there is of it [s]."""
        return float(self.probe["time"][-1])

    def largest_overlap(self):
        """Of any row of the series, over the smaller radius; nan without the series."""
        return float(self.solver["overlap_max"].max()) if self.solver is not None else float("nan")

    def penetration(self):
        """Deepest [m], when [s], and at the end [m]."""
        depth, at = peak(self.probe["time"], self.probe["penetration"])
        return depth, at, float(self.probe["penetration"][-1])

    def early_depth(self):
        """Deepest within the report's 0.08 s [m]; later it may sink slowly."""
        early = self.probe["time"] <= UNTIL * (1 + 1e-9)
        return float(self.probe["penetration"][early].max())

    def apogee(self):
        """How high the block flies above its first touch after the deepest point [m], and when [s]."""
        time, values = self.probe["time"], self.probe["penetration"]
        k = int(np.argmax(values))
        height, at = peak(time[k:], -values[k:])
        return height, at

    def rebound(self):
        """How far the block has come up again from the deepest point [m]."""
        values = self.probe["penetration"]
        k = int(np.argmax(values))
        return float(values[k] - values[k:].min())

    def pressure(self, name, interval=0.0):
        """Largest mean over an interval [s] of force per length [kN/m] within the report's 0.08 s, and when [s].

        A row is the mean since the row before, so means over whole rows are exact; 0: of a row. The middle of the interval
        is told, of a row its end.
        """
        gauge = self.gauges[name]
        return _largest_mean(gauge["time"], gauge["normal_0"] / 1e3, interval)

    def slab_force(self, interval=0.0):
        """The same of the force on the whole slab [kN]."""
        return _largest_mean(self._slab["time"], self._force() / 1e3, interval)

    def _force(self):
        """On the whole slab [N], row by row."""
        n = sum(column.startswith("normal_") for column in self._slab)
        return sum(self._slab[f"normal_{k}"] for k in range(n)) * self._slab_length() / n

    def _scene(self):
        return tomllib.loads((self.summary or {}).get("scene") or (self.folder / "scene.toml").read_text())

    def _slab_length(self):
        points = next(wall["points"] for wall in self._scene()["walls"] if wall["name"] == "slab")
        return abs(points[-1][0] - points[0][0])

    def momentum_to_slab(self):
        """What the slab took within the report's 0.08 s beyond the weight that lay on it, over the rock's momentum."""
        time, force = self._slab["time"], self._force()
        early = time <= UNTIL * (1 + 1e-9)
        taken = float(np.sum((force[early][1:] - force[0]) * np.diff(time[early])))
        scene = self._scene()
        rock = scene["grains"][0]
        mass = scene["materials"][rock["material"]]["density"] * math.pi * rock["radius"] ** 2
        return taken / (mass * -rock["velocity"][1])

    def losses(self):
        """channel -> share of all that was lost until the end."""
        lost = {name: float(self.energy[name][-1]) for name in LOSSES if name in self.energy}
        total = sum(lost.values())
        return {name: value / total for name, value in lost.items()} if total > 0 else {}


def _largest_mean(time, values, interval):
    early = time <= UNTIL * (1 + 1e-9)
    time, values = time[early], values[early]
    if interval <= 0:
        return peak(time, values)
    steps = np.diff(time)
    n = max(1, round(interval / float(np.median(steps))))
    gathered = np.concatenate([[0.0], np.cumsum(values[1:] * steps)])
    if len(gathered) <= n:
        return float("nan"), float("nan")
    means = (gathered[n:] - gathered[:-n]) / (time[n:] - time[:-n])
    k = int(np.argmax(means))
    return float(means[k]), float(0.5 * (time[k] + time[k + n]))
