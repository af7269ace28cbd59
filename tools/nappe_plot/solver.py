"""How well the contacts were solved: residual, overlaps, energies, contacts, against time."""

import matplotlib.pyplot as plt
import numpy as np

from . import palette, style

ENERGY_UNITS = [(1e9, "GJ"), (1e6, "MJ"), (1e3, "kJ"), (1.0, "J")]


def _positive(values):
    return np.where(values > 0, values, np.nan)


def _log(axis, series, columns, title, label):
    for k, (column, name) in enumerate(columns):
        if column in series and (series[column] > 0).any():
            axis.plot(series["time"], _positive(series[column]), color=palette.LINES[k], label=name, linewidth=1.5)
    axis.set_yscale("log")
    axis.set(title=title, ylabel=label)


def joules(values):
    """Size [J] and name of the unit that suits all of these series of energies."""
    largest = max(np.nanmax(abs(v)) for v in values)
    return next((size, unit) for size, unit in ENERGY_UNITS if largest >= size or size == 1.0)


def draw(run, chosen, out):
    """solver.png."""
    solver, energy = run.series("solver"), run.series("energy")
    if solver is None:
        return
    figure, axes = plt.subplots(2, 2, figsize=(15, 9.5), layout="constrained", sharex=True)
    residuals = [("residual", "largest"), ("residual_rms", "root mean square")]
    _log(axes[0, 0], solver, residuals, "Residual of the contact laws", "residual, relative to V")
    overlaps = [("overlap_max", "largest"), ("overlap_mean", "mean")]
    _log(axes[0, 1], solver, overlaps, "Overlap of grains", "overlap / radius")
    if energy is not None:
        change = energy["potential"] - energy["potential"][0]
        scale, unit = joules([change, energy["wall_work"]])
        axes[1, 0].plot(energy["time"], energy["wall_work"] / scale, color=palette.LINES[0], label="work of the walls")
        axes[1, 0].plot(energy["time"], change / scale, color=palette.LINES[1], label="potential energy gained")
        axes[1, 0].plot(energy["time"], energy["kinetic"] / scale, color=palette.LINES[2], label="kinetic energy")
        axes[1, 0].set(title="Energies", ylabel=f"energy [{unit} per metre of depth]")
    axes[1, 1].plot(solver["time"], solver["contacts"] / 1e3, color=palette.LINES[0], label="contacts with an impulse")
    axes[1, 1].plot(solver["time"], solver["candidates"] / 1e3, color=palette.LINES[1], label="candidate pairs")
    axes[1, 1].set(title="Contacts", ylabel="thousands", ylim=(0, None))
    for axis in axes.flat:
        if axis.get_legend_handles_labels()[0]:
            axis.legend(loc="best")
        axis.margins(x=0.01)
    for axis in axes[1]:
        axis.set_xlabel("time [s]")
    yield style.save(figure, out / "solver.png", style.DPI_CURVES)
