"""Tables in Markdown, which docs/rockfall.md holds between marks of their own."""

import re

import numpy as np

from . import plan
from .results import UNTIL

GAUGES = [f"P{k}" for k in range(1, 6)]


def _row(*cells):
    return "| " + " | ".join(str(cell) for cell in cells) + " |"


def _table(head, rows):
    return [_row(*head), _row(*["---"] * len(head)), *(_row(*row, *[""] * (len(head) - len(row))) for row in rows)]


def number(value):
    """Three digits, thousands with commas."""
    if not np.isfinite(value):
        return ""
    return f"{float(f'{value:.3g}'):,.0f}" if abs(value) >= 100 else f"{value:.3g}"


def _at(value, when):
    return f"{number(value)} at {1e3 * when:.1f}"


def runs(results):
    """A line a run: penetration, pressures, losses."""
    head = ["run", "deepest [cm]", "at [s]", "back up [cm]", *(f"{name} [kN/m] at [ms]" for name in GAUGES)]
    head += ["friction", "dashpots", "global", "impacts", "overlap max [r]", "steps"]
    rows = []
    for one in plan.planned():
        result = results.get(one.name)
        if result is None or one.group in ("seed", "undamped") or (one.group == "step" and "rigid" in one.name):
            continue  # they have tables of their own
        if result.failed and result.end < UNTIL:
            rows.append([one.name, _failure(result)])
            continue
        depth, at, _ = result.penetration()
        lost = result.losses()
        shares = [f"{100 * lost[name]:.0f} %" if name in lost else "" for name in ("friction", "dashpot", "damping", "impact")]
        summary = result.summary or {}
        rows.append([one.name, f"{100 * depth:.1f}", f"{at:.3f}", f"{100 * result.rebound():.1f}"]
                    + [_at(*result.pressure(name)) for name in GAUGES]
                    + [*shares, f"{result.largest_overlap():.2f}", summary.get("steps", "")])
    return _table(head, rows)


def _failure(result):
    """In the words of the page: what the program says of it is a line too long for a table."""
    what = "a grain goes through the slab" if "went through wall 'slab'" in result.reason else result.reason[:80]
    return f"unstable: {what} after {1e3 * result.end:.0f} ms"


def _samples(results, job):
    """Results of all samples of a job, by seed."""
    names = {1: job} | {seed: plan.seeded(job, seed) for seed in plan.SEEDS}
    return {seed: results[name] for seed, name in names.items() if name in results and not results[name].failed}


def spread(values):
    """Mean, standard deviation, and the range."""
    values = np.asarray(list(values), float)
    deviation = values.std(ddof=1) if len(values) > 1 else float("nan")
    return f"{number(values.mean())} ± {number(deviation)} ({number(values.min())} to {number(values.max())})"


def samples(results):
    """What runs of other samples differ by: the bar that every figure of one sample has."""
    head = ["run", "samples", "deepest within 0.08 s [cm]", "P1 [kN/m]", "at [ms]", "P2 [kN/m]", "P5 [kN/m]", "momentum to the slab"]
    rows = []
    for job in plan.SEEDED:
        found = list(_samples(results, job).values())
        if not found:
            continue
        rows.append([job, len(found), spread(100 * one.early_depth() for one in found),
                     spread(one.pressure("P1")[0] for one in found), spread(1e3 * one.pressure("P1")[1] for one in found),
                     spread(one.pressure("P2")[0] for one in found), spread(one.pressure("P5")[0] for one in found),
                     spread(one.momentum_to_slab() for one in found)])
    return _table(head, rows)


def _paired(results, job, other, figure):
    """figure(run of job, run of other) of every sample that both have."""
    these, those = _samples(results, job), _samples(results, other)
    return [figure(these[seed], those[seed]) for seed in these if seed in those]


def ratios(results):
    """The report's comparisons, sample by sample."""

    def ratio(gauge):
        return lambda one, other: one.pressure(gauge)[0] / other.pressure(gauge)[0]

    def later(one, other):
        return 1e3 * (one.pressure("P1")[1] - other.pressure("P1")[1])

    def within(one, _, upper="P1", lower="P2"):
        return one.pressure(upper)[0] / one.pressure(lower)[0]

    def outer(one, _):
        return within(one, _, "P5", "P1")

    springs = ["0.5-10-c", "0.5-2.5-c", "1-10-c", "1-2.5-c"]
    asked = [("P1, c over b", "0.5-10-c", "0.5-10-b", ratio("P1")), ("P1's peak, b after c [ms]", "0.5-10-b", "0.5-10-c", later)]
    for depth in ("0.5", "1"):
        asked += [(f"{gauge}, 10 m over 2.5 m on {depth} m", f"{depth}-10-c", f"{depth}-2.5-c", ratio(gauge)) for gauge in ("P1", "P2")]
        asked.append((f"P1's peak, 2.5 m after 10 m on {depth} m [ms]", f"{depth}-2.5-c", f"{depth}-10-c", later))
    for height in ("10", "2.5"):
        asked += [(f"{gauge}, 0.5 m over 1 m from {height} m", f"0.5-{height}-c", f"1-{height}-c", ratio(gauge)) for gauge in ("P1", "P2")]
    asked += [(f"P1 over P2 in {job}", job, job, within) for job in springs]
    asked += [("apogee in 1-10 [cm]", "1-10", "1-10", lambda one, _: 100 * one.apogee()[0]),
              ("its time in 1-10 [s]", "1-10", "1-10", lambda one, _: one.apogee()[1])]
    asked += [(f"P5 over P1 in {job}", job, job, outer) for job in springs]
    rows = []
    for text, job, other, figure in asked:
        values = _paired(results, job, other, figure)
        if values:
            rows.append([text, len(values), spread(values), ", ".join(number(value) for value in values)])
    return _table(["of each sample", "samples", "mean ± deviation (range)", "samples 1, 2, …"], rows)


def rigid(results):
    """Springs with and without C beside rigid grains."""
    head = ["run", "deepest [cm]", "at [s]", *(f"P1 over {text} [kN/m]" for text in ("0.1 ms", "1 ms", "5 ms"))]
    head += ["at [ms]", *(f"slab over {text} [kN]" for text in ("1 ms", "5 ms")), "momentum to the slab", "global", "steps", "seconds"]
    rows = []
    for depth in ("0.5", "1"):
        names = [f"{depth}-10-c", *(f"{depth}-10-c-{kind}" for kind in plan.UNDAMPED), f"{depth}-10-rigid"]
        names += [f"{depth}-10-rigid-half-step", f"{depth}-10-rigid-400-sweeps", f"{depth}-10-rigid-solved"]
        for name in names:
            if name in results and results[name].summary:
                rows.append(_beside(name, results[name]))
        for job in (f"{depth}-10-c", f"{depth}-10-rigid"):
            found = list(_samples(results, job).values())
            if len(found) > 1:
                rows.append([f"{job}, {len(found)} samples", spread(100 * one.penetration()[0] for one in found), "",
                             *(spread(one.pressure("P1", interval)[0] for one in found) for interval in (0, 1e-3, 5e-3)),
                             spread(1e3 * one.pressure("P1")[1] for one in found),
                             *(spread(one.slab_force(interval)[0] for one in found) for interval in (1e-3, 5e-3)),
                             spread(one.momentum_to_slab() for one in found)])
    return _table(head, rows)


def _beside(name, result):
    depth, at, _ = result.penetration()
    summary = result.summary
    return [name, f"{100 * depth:.1f}", f"{at:.3f}", *(number(result.pressure("P1", interval)[0]) for interval in (0, 1e-3, 5e-3)),
            f"{1e3 * result.pressure('P1')[1]:.1f}", *(number(result.slab_force(interval)[0]) for interval in (1e-3, 5e-3)),
            f"{result.momentum_to_slab():.2f}", f"{100 * result.losses().get('damping', 0):.0f} %", summary["steps"],
            f"{summary['seconds_loading']:.0f}"]


TABLES = {"runs": runs, "samples": samples, "ratios": ratios, "rigid": rigid}


def tables(results):
    """name -> lines."""
    return {name: make(results) for name, make in TABLES.items()}


def put_into(page, made):
    """The page with the tables made in the place of those between <!-- table NAME --> and <!-- end -->."""
    for name, lines in made.items():
        marked = re.compile(rf"(<!-- table {name} -->\n).*?(<!-- end -->)", re.S)
        if not marked.search(page):
            raise SystemExit(f"rockfall_study: the page has no <!-- table {name} --> … <!-- end -->")
        page = marked.sub(lambda found: found[1] + "\n".join(lines) + "\n" + found[2], page)
    return page
