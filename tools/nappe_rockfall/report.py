"""Tables in Markdown, and the pictures that docs/rockfall.md shows."""

import shutil
import subprocess
from pathlib import Path

from . import plan

TOOLS = Path(__file__).resolve().parents[1]


def _row(*cells):
    return "| " + " | ".join(str(cell) for cell in cells) + " |"


def _failed(result):
    return "exit code 4" in result.said


def tables(known):
    """A line a run: penetration, pressures, losses, cost."""
    yield _row("run", "deepest [cm]", "at [s]", "back up [cm]", *(f"P{k} [kN/m] at [ms]" for k in range(1, 6)),
               "friction", "dashpots", "global", "impacts", "overlap max [r]", "steps", "seconds")
    yield _row(*["---"] * 17)
    for planned, result in known:
        if result.probe is None or (_failed(result) and len(result.probe["time"]) < 3):
            yield _row(planned.name, "failed: " + _reason(result), *[""] * 15)
            continue
        depth, at, _ = result.penetration()
        pressures = []
        for k in range(1, 6):
            value, when = result.pressure(f"P{k}")
            pressures.append(f"{value:.3g} at {1e3 * when:.1f}")
        lost = result.losses()
        shares = [f"{100 * lost[name]:.0f} %" if name in lost else "" for name in ("friction", "dashpot", "damping", "impact")]
        summary = result.summary or {}
        name = planned.name + (" (failed: " + _reason(result) + ")" if _failed(result) else "")
        yield _row(name, f"{100 * depth:.1f}", f"{at:.3f}", f"{100 * result.rebound():.1f}", *pressures, *shares,
                   f"{summary.get('overlap_max', float('nan')):.2f}", summary.get("steps", ""), f"{summary.get('seconds_total', float('nan')):.1f}")


def _reason(result):
    lines = [line for line in result.said.splitlines() if line.startswith("nappe: ")]
    return lines[-1][7:90] + "…" if lines else "no reason"


def _plot(*arguments):
    subprocess.run([TOOLS / "plot", *map(str, arguments)], check=True, capture_output=True, text=True)


def _compare(results, names, only, out, target, labels=None):
    names = [name for name in names if name in results and results[name].probe is not None]
    if not names:
        return
    folders = [results[name].folder for name in names]
    _plot("--compare", *folders, "--labels", ",".join(labels or names), "--only", only, "--out", out)
    target = out / target
    shutil.move(out / f"{only}.png", target)
    yield target


def pictures(results, out):
    out.mkdir(parents=True, exist_ok=True)
    amorphous = ["1-10-c", *plan.LATTICES]
    yield from _compare(results, plan.ROWS, "penetration", out, "rockfall-penetration.png")
    yield from _compare(results, plan.ROWS, "gauges", out, "rockfall-gauges.png")
    yield from _compare(results, amorphous, "penetration", out, "rockfall-arrangements-penetration.png")
    yield from _compare(results, amorphous, "gauges", out, "rockfall-arrangements-gauges.png")
    both = ["0.5-10-a", "0.5-10-b", "0.5-10-c", "0.5-10-rigid", "1-10-c", "1-10-rigid"]
    yield from _compare(results, both, "penetration", out, "rockfall-rigid-penetration.png")
    yield from _compare(results, both, "gauges", out, "rockfall-rigid-gauges.png")
    yield from _compare(results, [name for name in results if "-mu" in name], "penetration", out, "rockfall-friction.png")
    for name in (*amorphous, "1-10-rigid"):
        if name in results and results[name].summary:
            _plot(results[name].folder, "--only", "impact,chains", "--times", "0.01,0.02,0.03,0.04,0.05", "--out", out)
            for kind in ("impact", "chains"):
                target = out / f"rockfall-{kind}-{name}.png"
                shutil.move(out / f"{kind}.png", target)
                yield target
