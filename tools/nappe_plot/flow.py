"""Coarse-grained fields: velocity (Fig. 13), the trishear model beside it, shear strain."""

import matplotlib.pyplot as plt
import numpy as np
from matplotlib.cm import ScalarMappable
from matplotlib.colors import LinearSegmentedColormap, Normalize

from . import fault, grains, style
from .views import zoomed

# Up to the wall's speed (0.8 of the scale) pale enough for arrows on it; darker where the flow is faster than the wall.
SPEEDS = LinearSegmentedColormap.from_list(
    "speeds", [(0, "#eef2f5"), (0.4, "#bad5e8"), (0.8, "#6aa6cf"), (1, "#0b3a72")]
)
STRAINS = LinearSegmentedColormap.from_list("strains", ["#f8f6ee", "#fdd49e", "#ef6548", "#990000", "#3a0008"])
MISFITS = LinearSegmentedColormap.from_list("misfits", ["#f6f5f9", "#d9d2e9", "#8e7cc3", "#3c1a78"])
SPEED_NORM = Normalize(0, 1.25)
MISFIT_NORM = Normalize(0, 0.3)
ARROWS_ACROSS = 44


def _speed(run):
    """By which velocities are divided [m/s]: of the wall that drives."""
    one = fault.of(run)
    if one is not None:
        return one.speed
    _, wall = run.moving_wall()
    return None if wall is None else float(np.hypot(wall["vx"], wall["vy"]).max())


def _measured(views):
    """Those views that have fields, and a wall that drives."""
    return [view for view in views if view.field is not None and _speed(view.run)]


def _panels(windows, n_columns):
    """A figure with a row of panels per window, all alike, room for a bar above each column."""
    aspect = windows[0].aspect
    width, left, gap = style.WIDE, 0.95, 0.35
    panel = (width - left - 0.25 - gap * (n_columns - 1)) / n_columns
    row = panel / aspect + 0.62
    height = 1.15 + len(windows) * row + 0.45
    figure = plt.figure(figsize=(width, height))
    axes = np.empty((len(windows), n_columns), object)
    for k in range(len(windows)):
        for c in range(n_columns):
            place = [(left + c * (panel + gap)) / width, (height - 1.15 - (k + 1) * row + 0.2) / height]
            axes[k, c] = figure.add_axes([*place, panel / width, panel / aspect / height])
            axes[k, c].tick_params(labelleft=c == 0, labelbottom=k == len(windows) - 1)
        axes[k, 0].set_ylabel("y [m]")
    for axis in axes[-1]:
        axis.set_xlabel("x [m]")
    return figure, axes


def _bar(figure, axis, norm, colours, label, extend="neither"):
    """Above the column that the axis heads."""
    box, height = axis.get_position(), figure.get_figheight()
    length = min(box.width, 4.6 / figure.get_figwidth())
    place = figure.add_axes([box.x1 - length, 1 - 0.62 / height, length, 0.15 / height])
    figure.colorbar(ScalarMappable(norm, colours), cax=place, orientation="horizontal", extend=extend)
    place.set_title(label, fontsize=13)
    place.tick_params(labelsize=11)


def _map(axis, field, values, norm, colours):
    """Values at nodes as squares around them; blank where there is no material."""
    axis.pcolormesh(field.x, field.y, values, norm=norm, cmap=colours, shading="nearest", rasterized=True, zorder=1)


def _finish(axis, view, window, marks=True, thin=False):
    grains.draw_walls(axis, view.frame)
    if marks:
        fault.draw_marks(axis, view.run, view.frame, thin)
    window.apply(axis)


def draw_velocity(views, out):
    """velocity.png: speed over that of the wall by colour, arrows on a coarser grid."""
    views = _measured(views)
    if not views:
        return
    windows = zoomed(views)
    figure, axes = _panels(windows, 1)
    for axis, view, window in zip(axes[:, 0], views, windows):
        field, v0 = view.field, _speed(view.run)
        _map(axis, field, field.speed / v0, SPEED_NORM, SPEEDS)
        step = max(1, round((window.x[1] - window.x[0]) / ARROWS_ACROSS / (field.x[1] - field.x[0])))
        pick = np.s_[step // 2 :: step]
        arrows = field.velocity[pick, pick] / v0
        length = 0.85 * step * (field.x[1] - field.x[0])  # m, of an arrow as fast as the wall
        axis.quiver(
            field.x[pick],
            field.y[pick],
            np.where(np.hypot(*np.moveaxis(arrows, -1, 0)) > 0.03, arrows[..., 0], np.nan),
            arrows[..., 1],
            units="xy",
            angles="xy",
            scale=1 / length,
            width=0.07 * length,
            headwidth=3.6,
            headlength=4.2,
            headaxislength=3.8,
            color="#111111",
            zorder=3,
        )
        _finish(axis, view, window)
        axis.set_title(view.label, loc="left")
    _bar(figure, axes[0, 0], SPEED_NORM, SPEEDS, "speed / speed of the wall", "max")
    yield style.save(figure, out / "velocity.png", style.DPI_FIELDS)


def draw_trishear(views, out):
    """trishear.png: speed as measured, speed of the fitted model, size of the difference of the two velocities."""
    views = [view for view in _measured(views) if view.zone and np.isfinite(view.zone["trishear_residual"])]
    if not views:
        return
    windows = zoomed(views)
    figure, axes = _panels(windows, 3)
    for row, view, window in zip(axes, views, windows):
        field, zone, one = view.field, view.zone, fault.of(view.run)
        x, y = np.meshgrid(field.x, field.y)
        model = fault.trishear(one, zone, x, y)
        model[np.isnan(field.speed)] = np.nan
        difference = np.hypot(*np.moveaxis(field.velocity - model, -1, 0))
        _map(row[0], field, field.speed / one.speed, SPEED_NORM, SPEEDS)
        _map(row[1], field, np.hypot(model[..., 0], model[..., 1]) / one.speed, SPEED_NORM, SPEEDS)
        _map(row[2], field, difference / one.speed, MISFIT_NORM, MISFITS)
        for axis in row:
            _finish(axis, view, window, marks=False)
            axis.plot(zone["trishear_x"], zone["trishear_y"], "o", color="#d55e00", markersize=7, zorder=6)
        row[0].set_title(view.label, loc="left", fontsize=13)
        angle = 2 * np.degrees(zone["trishear_half_angle"])
        row[1].set_title(f"apical angle {angle:.0f}°, s = {zone['trishear_s']:.2g}", loc="left", fontsize=13)
        row[2].set_title(f"RMS {zone['trishear_residual']:.3f}", loc="left", fontsize=13)
    _bar(figure, axes[0, 0], SPEED_NORM, SPEEDS, "measured: speed / $V_0$", "max")
    _bar(figure, axes[0, 1], SPEED_NORM, SPEEDS, "trishear model: speed / $V_0$", "max")
    _bar(figure, axes[0, 2], MISFIT_NORM, MISFITS, "|measured − model| / $V_0$", "max")
    yield style.save(figure, out / "trishear.png", style.DPI_FIELDS)


def _scale(views, windows, pick):
    """From 0 to what 1 % of the nodes in sight exceed in the panel where that is most."""
    highest = 0.0
    for view, window in zip(views, windows):
        field = view.field
        x, y = np.meshgrid(field.x, field.y)
        values = pick(field)[window.holds(np.column_stack([x.ravel(), y.ravel()])).reshape(x.shape)]
        values = values[np.isfinite(values)]
        if len(values):
            highest = max(highest, float(np.quantile(values, 0.99)))
    return Normalize(0, highest or 1.0)


def draw_strain(views, out):
    """strain.png: rate of shear since the frame before, and shear strain since the start; faults show as bands."""
    views = [view for view in _measured(views) if view.frame.time > 0]
    if not views:
        return
    windows = zoomed(views)
    columns = [
        (lambda field: field.shear_rate, "shear rate since the frame before [1/s]"),
        (lambda field: field.shear_strain, "shear strain since the start"),
    ]
    norms = [_scale(views, windows, pick) for pick, _ in columns]
    figure, axes = _panels(windows, 2)
    for row, view, window in zip(axes, views, windows):
        for axis, (pick, _), norm in zip(row, columns, norms):
            _map(axis, view.field, pick(view.field), norm, STRAINS)
            _finish(axis, view, window, thin=True)
        row[0].set_title(view.label, loc="left")
    for axis, norm, (_, label) in zip(axes[0], norms, columns):
        _bar(figure, axis, norm, STRAINS, label, "max")
    yield style.save(figure, out / "strain.png", style.DPI_FIELDS)
