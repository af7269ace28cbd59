"""Where the work of the walls goes: the energy budget against time (output.measures.energy)."""

import matplotlib.pyplot as plt

from . import palette, solver, style

# Column, sign with which it adds to the kinetic energy (what is lost is stored positive), label.
TERMS = [
    ("wall_work", 1, "work of the walls"),
    ("gravity", 1, "work of gravity"),
    ("friction", -1, "friction"),
    ("impact", -1, "impacts"),
    ("cohesion", -1, "cohesion"),
    ("spring", -1, "springs"),
    ("dashpot", -1, "contact damping"),
    ("damping", -1, "global damping"),
    ("theta_term", 1, r"scheme, $\theta \neq 1/2$"),
]
# Of contacts some are rigid and some smooth, never both in a stage.
COLOURS = dict(zip([name for name, _, _ in TERMS], [*palette.LINES[:6], palette.LINES[4], palette.LINES[3], palette.LINES[5]]))


def draw(views, out):
    """budget.png: a panel per run, to one scale. What adds energy is positive; the sum is the kinetic energy gained."""
    runs = list({id(view.run): view for view in views}.values())
    known = [(view, view.run.series("energy")) for view in runs]
    known = [(view, energy) for view, energy in known if energy is not None and "friction" in energy]
    if not known:
        return
    n_rows = (len(known) + 1) // 2
    n_columns = min(len(known), 2)
    size = (15, 5.2 * n_rows + 0.4) if n_columns == 2 else style.PLOT
    figure, axes = plt.subplots(n_rows, n_columns, figsize=size, squeeze=False, sharey=True, layout="constrained")
    scale, unit = solver.joules([energy[name] for _, energy in known for name, _, _ in TERMS if name in energy])
    for axis, (view, energy) in zip(axes.flat, known):
        gained = energy["kinetic"] - energy["kinetic"][0]
        acting = [term for term in TERMS if term[0] in energy and abs(energy[term[0]]).max() > 0]
        for name, sign, label in acting:
            axis.plot(energy["time"], sign * energy[name] / scale, color=COLOURS[name], label=label)
        axis.plot(energy["time"], gained / scale, color=palette.INK, label="kinetic energy gained")
        axis.plot(energy["time"], energy["error"] / scale, color=palette.MUTED, linestyle=":", label="error of the sum")
        axis.set(xlabel="time [s]", title=view.label if len(known) > 1 else "")
        axis.margins(x=0.01)
    for axis in axes[:, 0]:
        axis.set_ylabel(f"energy [{unit} per metre of depth]")
    for axis in axes.flat[len(known) :]:
        axis.remove()
    drawn = [axis.get_legend_handles_labels() for axis, _ in zip(axes.flat, known)]
    handles = {label: handle for pair in drawn for handle, label in zip(*pair)}
    axes[0, -1].legend(handles.values(), handles.keys(), loc="center left", bbox_to_anchor=(1.01, 0.5))
    yield style.save(figure, out / "budget.png", style.DPI_CURVES)
