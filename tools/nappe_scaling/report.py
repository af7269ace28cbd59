"""Tables in Markdown and a picture per case."""

import matplotlib.pyplot as plt
from nappe_plot import palette, style

HALF = 0.5  # of the ideal: below it, ranks are mostly wasted


def _time(seconds):
    for unit, name in ((1.0, "s"), (1e-3, "ms"), (1e-6, "µs")):
        if seconds >= unit:
            return f"{seconds / unit:.3g} {name}"
    return f"{1e6 * seconds:.2g} µs"


class Row:
    """A number of ranks: its sample, cut, sweep and step."""

    def __init__(self, sample, cut, one_sweep, one_step):
        self.parts, self.cut, self.sweep, self.step = cut.parts, cut, one_sweep, one_step
        self.per_rank = sample.grains / cut.parts


def efficiency(rows, weak, seconds):
    """Of each row against the first: speed-up per rank, or, for weak scaling, time by time."""
    first = rows[0]
    base = seconds(first) * (1 if weak else first.parts)
    return [base / (seconds(row) * (1 if weak else row.parts)) for row in rows]


def table(rows, weak):
    lines = [
        "| ranks | grains a rank | imbalance | messages, most | bytes, most | sweep | bounds | exposed | step | "
        "efficiency |",
        "| ---: | ---: | ---: | ---: | ---: | ---: | ---: | ---: | ---: | ---: |",
    ]
    for row, part in zip(rows, efficiency(rows, weak, lambda r: r.step.total)):
        cut = row.cut
        messages = cut.per_part(cut.sender).sum(axis=1).max()
        sent = cut.per_part(cut.sender, cut.bytes).sum(axis=1).max()
        lines.append(
            f"| {row.parts} | {row.per_rank:,.0f} | {cut.imbalance:.3f} | {messages:.0f} | {sent:,.0f} | "
            f"{_time(row.sweep.coupled)} | {_time(row.sweep.work)} – {_time(row.sweep.barrier)} | "
            f"{100 * row.sweep.exposed:.0f} % | {_time(row.step.total)} | {100 * part:.0f} % |"
        )
    return "\n".join(lines)


def half_point(rows, weak):
    """A sentence: where the efficiency of a step falls below a half."""
    parts = efficiency(rows, weak, lambda r: r.step.total)
    for k, (row, part) in enumerate(zip(rows, parts)):
        if part < HALF:
            last = rows[k - 1]
            return (
                f"Efficiency falls below 50 % between {last.parts} and {row.parts} ranks, between {last.per_rank:,.0f} "
                f"and {row.per_rank:,.0f} grains a rank."
            )
    last = rows[-1]
    return f"Efficiency stays above 50 % up to {last.parts} ranks, {last.per_rank:,.0f} grains a rank."


def error_by_tiles(grains, tiles):
    """A table: what counting by tiles gives against counting by grains, of the same sample."""

    def figures(cut):
        sends = cut.per_part(cut.sender).sum(axis=1)
        sent = cut.per_part(cut.sender, cut.bytes).sum(axis=1)
        return [cut.relaxations.mean(), cut.relaxations.max(), sends.mean(), sends.max(), sent.mean(), sent.max()]

    lines = [
        "| ranks | relaxations, mean | most | messages, mean | most | bytes, mean | most |",
        "| ---: | ---: | ---: | ---: | ---: | ---: | ---: |",
    ]
    for parts, cut in grains.cuts.items():
        if parts > 1 and parts in tiles.cuts:
            pairs = zip(figures(tiles.cuts[parts]), figures(cut))
            lines.append(f"| {parts} | " + " | ".join(f"{100 * (a / b - 1):+.1f} %" for a, b in pairs) + " |")
    return "\n".join(lines)


def picture(rows, case, machine, path):
    """Time of a step with its bounds, and efficiency, against ranks."""
    figure, (left, right) = plt.subplots(1, 2, figsize=(13, 5), layout="constrained")
    ranks = [row.parts for row in rows]
    first = rows[0].step.total
    ideal = [first if case.weak else first * rows[0].parts / n for n in ranks]
    left.plot(ranks, [1e3 * t for t in ideal], color=palette.INK, linestyle=":", label="ideal")
    low, high = ([1e3 * getattr(row.step, name) for row in rows] for name in ("fastest", "slowest"))
    left.fill_between(ranks, low, high, color=palette.LINES[0], alpha=0.25, label="between the bounds")
    left.plot(ranks, [1e3 * row.step.total for row in rows], color=palette.LINES[0], marker="o", label="model")
    left.set(title="Time of a step", ylabel="time [ms]", yscale="log")
    for name, colour, label in (("total", palette.LINES[0], "step"), ("sweeps", palette.LINES[1], "its sweeps")):
        parts = efficiency(rows, case.weak, lambda row, name=name: getattr(row.step, name))
        right.plot(ranks, [100 * p for p in parts], color=colour, marker="o", label=label)
    right.axhline(100 * HALF, color=palette.INK, linestyle=":", linewidth=1)
    right.set(title="Efficiency", ylabel="efficiency [%]", ylim=(0, None))
    for axis in (left, right):
        axis.set_xscale("log", base=2)
        axis.set_xlabel("ranks")
        axis.legend(loc="best")
    figure.suptitle(f"{case.title}; {machine.name}", fontsize=14)
    return style.save(figure, path, 72)
