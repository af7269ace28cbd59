"""What settings cost and how far they are from the reference: the folder that `nappe trade` leaves."""

import json

import matplotlib.pyplot as plt
import numpy as np
from matplotlib.ticker import LogLocator, NullFormatter

from . import palette, style
from .errors import BadRun

TABLE = "trade.json"
COSTS = {"relaxations": ("relaxations", "relaxations"), "seconds": ("seconds_steps", "seconds of the steps")}
# Key of the error, title, label.
ERRORS = [
    ("overlap_mean", "Mean overlap, at the end", "overlap / radius"),
    ("overlap_max_of_rows", "Largest overlap", "overlap / radius"),
    ("residual_largest", "Largest residual", "residual, relative to V"),
    ("observable_error", "Observables: root mean square difference", "difference / scatter between seeds"),
]
SETTING, FRONT, REFERENCE = palette.LINES[0], palette.LINES[1], palette.INK


def is_trade(folder):
    return (folder / TABLE).exists()


def read(folder):
    path = folder / TABLE
    try:
        table = json.loads(path.read_text())
        names = [row["name"] for row in table["settings"]]
    except (OSError, json.JSONDecodeError, KeyError, TypeError) as error:
        raise BadRun(f"{path} is not a table of nappe trade: {error}") from error
    if not names or names[0] != "reference":
        raise BadRun(f"{path} must begin with the reference, found {names[:1]}")
    return table


def _number(row, key):
    value = row.get(key)
    return np.nan if value is None else float(value)


def front(cost, error):
    """Indices of the points that no other beats in both, by ascending cost; NaN is on no front."""
    known = [k for k in range(len(cost)) if np.isfinite(cost[k]) and np.isfinite(error[k])]

    def beaten(k):
        return any(
            cost[j] <= cost[k] and error[j] <= error[k] and (cost[j] < cost[k] or error[j] < error[k]) for j in known
        )

    return sorted((k for k in known if not beaten(k)), key=lambda k: (cost[k], -error[k]))


def _limits(values, factor):
    """Of a logarithmic axis that holds all of them with room for names."""
    known = [v for v in values if np.isfinite(v) and v > 0]
    return (min(known) / factor, max(known) * factor) if known else (0.1, 1.0)


def _label(axis, x, y, names, colours):
    """Names beside their points, from the top down, each where it meets no other as far as there is a place."""
    figure = axis.figure
    figure.canvas.draw()
    renderer = figure.canvas.get_renderer()
    points = axis.transData.transform(np.column_stack([x, y]))
    taken = [(px - 6, py - 6, px + 6, py + 6) for px, py in points]
    frame = axis.get_window_extent(renderer)
    places = [(dx, dy, "left" if dx > 0 else "right") for dy in (5, -14, 20, -29, 35) for dx in (9, -9)]
    for k in sorted(range(len(names)), key=lambda k: -points[k][1]):
        best = None
        for dx, dy, side in places:
            text = axis.annotate(
                names[k], (x[k], y[k]), (dx, dy), textcoords="offset points", ha=side, fontsize=11, color=colours[k]
            )
            box = text.get_window_extent(renderer)
            hits = sum(box.x0 < b[2] and b[0] < box.x1 and box.y0 < b[3] and b[1] < box.y1 for b in taken)
            hits += 2 * (box.x0 < frame.x0 or box.x1 > frame.x1 or box.y0 < frame.y0 or box.y1 > frame.y1)
            if best is None or hits < best[0]:
                if best is not None:
                    best[1].remove()
                best = (hits, text, box)
            else:
                text.remove()
            if hits == 0:
                break
        box = best[2]
        taken.append((box.x0, box.y0, box.x1, box.y1))


def _panel(axis, rows, n_seeds, cost_key, cost_label, error):
    key, title, label = error
    cost = [_number(row, cost_key) for row in rows]
    found = [_number(row, key) for row in rows]
    judged = [row["status"] == "done" for row in rows]
    judged[0] = False  # the reference is what settings are compared with
    on_front = front([c if j else np.nan for c, j in zip(cost, judged)], found)
    drawn = [k for k in range(len(rows)) if np.isfinite(cost[k]) and np.isfinite(found[k])]
    is_observables = key == "observable_error"
    drawn = [k for k in drawn if not (is_observables and k == 0)]  # its difference from itself is nothing
    # What is exactly 0 (a residual may be) has no place on a logarithmic axis: it stands at the foot.
    positive = [found[k] for k in drawn if found[k] > 0]
    foot = min(positive) / 10 if positive else 0.1
    shown = [max(found[k], foot) for k in range(len(rows))]
    axis.set(xscale="log", yscale="log", title=title, ylabel=label, xlabel=cost_label)
    axis.set_xlim(_limits(cost, 4))
    if not drawn:
        why = "one seed: no scatter is known" if is_observables and n_seeds < 2 else "nothing measured"
        axis.text(0.5, 0.5, why, transform=axis.transAxes, ha="center", color=palette.MUTED)
        axis.set_ylim(0.1, 1)
        return
    extent = [shown[k] for k in drawn]
    if is_observables:
        noise = float(np.nanmedian([_number(row, "observable_noise") for row in rows[1:]]))
        extent += [1.0]
        axis.axhspan(0, 1, color=palette.MUTED, alpha=0.16, linewidth=0, label="scatter of the reference between seeds")
        if np.isfinite(noise) and noise > 0:
            extent += [noise]
            axis.axhline(noise, color=palette.MUTED, linestyle=":", label="what chance leaves with so many seeds")
    elif np.isfinite(found[0]):
        axis.axhline(shown[0], color=REFERENCE, linestyle="--", linewidth=1.2, zorder=1)
    axis.set_ylim(_limits(extent, 3))
    if len(on_front) > 1:
        steps = [cost[k] for k in on_front], [shown[k] for k in on_front]
        axis.step(*steps, where="post", color=FRONT, linewidth=1.6, zorder=2)
    colours = [REFERENCE if k == 0 else FRONT if k in on_front else SETTING for k in range(len(rows))]
    for k in drawn:
        marker = "*" if k == 0 else "o" if judged[k] else "x"
        axis.plot(cost[k], shown[k], marker, color=colours[k], markersize=13 if k == 0 else 9, zorder=4)
    axis.yaxis.set_major_locator(LogLocator(numticks=9))
    axis.yaxis.set_minor_formatter(NullFormatter())
    return drawn, cost, shown, colours


def draw(folder, out):
    """trade-relaxations.png, trade-seconds.png: cost against error, settings named, Pareto front marked."""
    table = read(folder)
    rows, n_seeds = table["settings"], len(table["seeds"])
    for name, (cost_key, cost_label) in COSTS.items():
        # Placed by hand: names are put beside their points by pixels, so nothing may move any more.
        figure, axes = plt.subplots(2, 2, figsize=(17, 12.5))
        figure.subplots_adjust(left=0.07, right=0.985, top=0.92, bottom=0.145, hspace=0.28, wspace=0.17)
        panels = [
            _panel(axis, rows, n_seeds, cost_key, cost_label, error) for axis, error in zip(axes.flat, ERRORS)
        ]
        seeds = "one seed" if n_seeds == 1 else f"{n_seeds} seeds"
        figure.suptitle(f"{table.get('title') or folder.name}: cost against error, {seeds}", fontsize=17)
        handles = [
            plt.Line2D([], [], color=REFERENCE, marker="*", markersize=13, linestyle="--", label="the reference"),
            plt.Line2D([], [], color=FRONT, marker="o", markersize=9, linewidth=1.6, label="on the Pareto front"),
            plt.Line2D([], [], color=SETTING, marker="o", markersize=9, linestyle="", label="beaten in both"),
        ]
        if any(row["status"] != "done" for row in rows):
            mark = {"color": SETTING, "marker": "x", "markersize": 9, "linestyle": ""}
            handles.append(plt.Line2D([], [], **mark, label="runs are missing"))
        handles += axes[1, 1].get_legend_handles_labels()[0]
        figure.legend(handles=handles, loc="lower center", ncol=3)
        names = [row["name"] for row in rows]
        for axis, panel in zip(axes.flat, panels):
            if panel:
                drawn, cost, shown, colours = panel
                _label(axis, *([values[k] for k in drawn] for values in (cost, shown, names, colours)))
        yield style.save(figure, out / f"trade-{name}.png", style.DPI_CURVES)
