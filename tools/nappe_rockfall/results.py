"""What a run's folder says of the impact."""

import json

import numpy as np

from nappe_plot import tables

LOSSES = ["friction", "dashpot", "damping", "impact"]


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
        self.energy = tables.read(folder / "series" / "energy.csv")
        self.gauges = {f"P{k}": tables.read(folder / "series" / f"gauge-P{k}.csv") for k in range(1, 6)}

    def penetration(self):
        """Deepest [m], when [s], and at the end [m]."""
        depth, at = peak(self.probe["time"], self.probe["penetration"])
        return depth, at, float(self.probe["penetration"][-1])

    def rebound(self):
        """How far the block has come up again from the deepest point [m]."""
        values = self.probe["penetration"]
        k = int(np.argmax(values))
        return float(values[k] - values[k:].min())

    def pressure(self, name, until=0.08):
        """Peak [kN/m] within the report's 0.08 s, when [s]."""
        gauge = self.gauges[name]
        early = gauge["time"] <= until
        value, at = peak(gauge["time"][early], gauge["normal_0"][early])
        return value / 1e3, at

    def losses(self):
        """channel -> share of all that was lost until the end."""
        lost = {name: float(self.energy[name][-1]) for name in LOSSES if name in self.energy}
        total = sum(lost.values())
        return {name: value / total for name, value in lost.items()} if total > 0 else {}
