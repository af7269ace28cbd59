"""The fault of a scene (output.zone) and its zone as measured: lines for the pictures, and the trishear model."""

import numpy as np
from matplotlib.patheffects import Normal, withStroke

from . import palette

HALO = [withStroke(linewidth=4.5, foreground="white", alpha=0.85), Normal()]  # readable on dark and pale layers
FAULT_LINE = {"color": palette.INK, "linewidth": 2.0, "solid_capstyle": "butt", "zorder": 5, "path_effects": HALO}
LIMIT_LINE = {**FAULT_LINE, "linestyle": (0, (5, 3)), "dash_capstyle": "butt"}


class Fault:
    """The tip [m] and the velocity [m/s] of the wall that drives, with its direction."""

    def __init__(self, tip, velocity):
        self.tip = np.array(tip, float)
        self.speed = float(np.hypot(*velocity))
        self.along = np.array(velocity, float) / self.speed
        self.across = np.array([-self.along[1], self.along[0]])

    def line(self, y):
        """Where the fault's line, from the tip on, is at height y."""
        return self.tip[0] + (y - self.tip[1]) * self.along[0] / self.along[1]


def of(run):
    """The fault of the run's scene, or None."""
    zone = run.scene.get("output", {}).get("zone")
    if zone is None:
        return None
    walls = {wall.get("name"): wall for wall in run.scene.get("walls", [])}
    velocity = walls.get(zone.get("wall"), {}).get("motion", {}).get("velocity")
    return Fault(zone["tip"], velocity) if velocity and velocity[1] != 0 else None


def row_at(table, time):
    """The figures of a table at the row nearest the time, or None if it has no row within a thousandth of the last."""
    if table is None:
        return None
    row = int(np.argmin(abs(table["time"] - time)))
    near = abs(table["time"][row] - time) <= 1e-3 * max(abs(table["time"][-1]), 1e-9)
    return {name: values[row] for name, values in table.items()} if near else None


def limits(fault, zone):
    """(x at the tip's height, angle) of the left and of the right limit; those that could be measured."""
    pairs = [(zone[f"{side}_x"], zone[f"{side}_angle"]) for side in ("left", "right")]
    return [(x, angle) for x, angle in pairs if np.isfinite(x) and np.isfinite(angle)]


def draw_marks(axis, run, frame, thin=False):
    """As in the paper's Figs. 12 and 13: the fault's direction, the zone's limits dashed, an arrow at the front.

    What was not measured is left out. Thin lines do not hide what lies along them.
    """
    fault = of(run)
    if fault is None:
        return
    top = frame.x[:, 1].max()
    thinner = {"linewidth": 0.9, "path_effects": None} if thin else {}
    axis.plot(*zip(fault.tip, (fault.line(top), top)), **(FAULT_LINE | thinner))
    zone = row_at(run.measured("zone"), frame.time)
    if zone is not None:
        for x, angle in limits(fault, zone):
            axis.plot([x, x + (top - fault.tip[1]) / np.tan(angle)], [fault.tip[1], top], **(LIMIT_LINE | thinner))
    surface = row_at(run.measured("surface"), frame.time)
    if surface is not None and np.isfinite(surface["front"]):
        near = abs(frame.x[:, 0] - surface["front"]) < 4 * frame.radius.mean()
        foot = (frame.x[near, 1] + frame.radius[near]).max() if near.any() else fault.tip[1]
        length = 0.22 * (top - fault.tip[1])
        arrow = {"arrowstyle": "-|>,head_width=0.35,head_length=0.7", "linewidth": 2.2, "color": palette.INK}
        axis.annotate("", (surface["front"], foot), (surface["front"], foot + length), arrowprops=arrow, zorder=6)


def trishear(fault, zone, x, y):
    """Velocity (…, 2) of the fitted trishear field (Zehnder and Allmendinger 2000, eq. 6) at the points (x, y).

    From the fit's apex on, x along the fault and y across it; m is the tangent of half the apical angle. Inside, where
    |y| < m x: v_x = (v0/2) [sgn(y) (|y|/(m x))^(1/s) + 1] and v_y = (v0/2) (m/(1 + s)) [(|y|/(m x))^((1 + s)/s) - 1].
    Above it is (v0, 0), below it rest.
    """
    dx, dy = x - zone["trishear_x"], y - zone["trishear_y"]
    along = fault.along[0] * dx + fault.along[1] * dy
    across = fault.across[0] * dx + fault.across[1] * dy
    m, s = np.tan(zone["trishear_half_angle"]), zone["trishear_s"]
    inside = abs(across) < m * along
    ratio = np.where(inside, abs(across) / np.where(inside, m * along, 1.0), 1.0)
    v_along = 0.5 * fault.speed * (np.sign(across) * ratio ** (1 / s) + 1)
    v_across = 0.5 * fault.speed * m / (1 + s) * (ratio ** ((1 + s) / s) - 1)
    return v_along[..., None] * fault.along + v_across[..., None] * fault.across
