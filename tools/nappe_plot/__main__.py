"""tools/plot: draws the pictures of a run and prints their paths."""

import argparse
import sys
from pathlib import Path

from . import budget, cells, chains, compared, curves, flow, impact, layers, profile, solver, style, trade, views
from .run import BadRun, Run


def _views(draw):
    """A drawing of views as one of a run at the times chosen."""
    return lambda run, chosen, out: draw(views.of_one(run, chosen), out)


# In the order of drawing: a name for --only, what draws it, and what a run must have for it.
PICTURES = {
    "layers": (layers.draw, "frames"),
    "zoom": (layers.draw_zoom, "frames"),
    "stress": (curves.draw_stress, "series of cells"),
    "lambda": (curves.draw_lambda, "series of cells"),
    "front": (curves.draw_front, "the series front and a wall that moves"),
    "cells": (cells.draw, "cells with grains"),
    "chains": (_views(chains.draw), "contacts with an impulse in the frames chosen"),
    "solver": (solver.draw, "the series solver"),
    "profile": (_views(profile.draw), "fault (output.zone and a wall that moves)"),
    "velocity": (_views(flow.draw_velocity), "fields in measures/ (nappe measure) and a wall that moves"),
    "trishear": (_views(flow.draw_trishear), "fields and zone in measures/ (nappe measure)"),
    "strain": (_views(flow.draw_strain), "fields in measures/ (nappe measure) after the start"),
    "budget": (_views(budget.draw), "energy budget (output.measures.energy)"),
    "gauges": (impact.draw_gauges, "gauges of one bin (output.gauges)"),
    "penetration": (impact.draw_fall, "probes (output.probes)"),
    "impact": (impact.draw_impact, "gauge with several bins (output.gauges)"),
}
# Of the folder of a matrix of settings (nappe trade).
TRADE = {"trade": (trade.draw, "settings")}
# The same of several runs, side by side.
COMPARED = {
    "profile": (profile.draw, "fault (output.zone and a wall that moves)"),
    "velocity": (flow.draw_velocity, "fields in measures/ (nappe measure) and a wall that moves"),
    "trishear": (flow.draw_trishear, "fields and zone in measures/ (nappe measure)"),
    "strain": (flow.draw_strain, "fields in measures/ (nappe measure) after the start"),
    "stress": (compared.draw_stress, "series of a cell that all have"),
    "lambda": (compared.draw_lambda, "series of a cell that all have"),
    "cells": (compared.draw_cells, "cells that all have"),
    "zone": (compared.draw_zone, "zone in measures/ (nappe measure)"),
    "budget": (budget.draw, "energy budget (output.measures.energy)"),
    "chains": (chains.draw, "contacts with an impulse in their frames"),
    "gauges": (impact.draw_gauges_compared, "gauges of one bin (output.gauges)"),
    "penetration": (impact.draw_fall_compared, "probes (output.probes)"),
}


def times(text):
    try:
        return [float(part) for part in text.split(",")]
    except ValueError:
        raise argparse.ArgumentTypeError(f'times are numbers [s] with commas between them; found "{text}"') from None


def names(text):
    chosen = text.split(",")
    unknown = [name for name in chosen if name not in PICTURES | COMPARED | TRADE]
    if unknown:
        known = ", ".join(PICTURES | COMPARED | TRADE)
        raise argparse.ArgumentTypeError(f'no picture "{unknown[0]}"; there are {known}')
    return chosen


def parse():
    parser = argparse.ArgumentParser(prog="tools/plot", description="Draws the pictures of a run, or of several runs.")
    parser.add_argument("dirs", metavar="DIR", nargs="+", type=Path, help="what nappe run --out wrote, or nappe trade")
    parser.add_argument("--compare", action="store_true", help="the runs in each picture, at their last frames")
    parser.add_argument("--labels", type=lambda text: text.split(","), help="of the runs compared (gamma, or folders)")
    parser.add_argument("--times", type=times, help="of the frames to draw [s]: 0,200,350,500; the nearest are taken")
    parser.add_argument("--out", type=Path, help="where the pictures go (DIR/pictures; compared: beside the first DIR)")
    parser.add_argument("--only", type=names, help=f"some of {', '.join(PICTURES)}; compared: {', '.join(COMPARED)}")
    parser.add_argument("--until", type=float, default=style.UNTIL, help="where curves of gauges and penetration end [s] (at their end)")
    parser.add_argument("--dpi", type=int, help="of the pictures of grains, which are 16 inches wide (300)")
    arguments = parser.parse_args()
    if not arguments.compare and len(arguments.dirs) > 1:
        parser.error(f"{len(arguments.dirs)} folders are given; --compare draws several runs, else give one")
    if arguments.compare and arguments.times and len(arguments.times) > 1:
        parser.error(f"--compare draws each run at one time; found {len(arguments.times)} in --times")
    if arguments.labels and len(arguments.labels) != len(arguments.dirs):
        parser.error(f"one label per folder is wanted; found {len(arguments.labels)} for {len(arguments.dirs)} folders")
    return arguments


def pictures_of(arguments):
    """Pairs: name and what is needed, and the paths as they are drawn."""
    if trade.is_trade(arguments.dirs[0]) and not arguments.compare:
        folder = arguments.dirs[0].resolve()
        yield from _drawn(arguments, TRADE, (folder, arguments.out or folder / "pictures"), "nappe trade")
        return
    runs = [Run(folder) for folder in arguments.dirs]
    if arguments.compare:
        labels = arguments.labels or views.default_labels(runs)
        seen = views.of_several(runs, labels, arguments.times and arguments.times[0])
        out = arguments.out or runs[0].folder.parent / "pictures"
        yield from _drawn(arguments, COMPARED, (seen, out), "several runs")
    else:
        run = runs[0]
        inputs = (run, run.choose(arguments.times), arguments.out or run.folder / "pictures")
        yield from _drawn(arguments, PICTURES, inputs, "one run")


def _drawn(arguments, known, inputs, of_what):
    for name in arguments.only or known:
        if name not in known:
            raise BadRun(f"no picture {name} of {of_what}")
        draw, needs = known[name]
        yield name, needs, draw(*inputs)


def main():
    arguments = parse()
    style.apply()
    style.UNTIL = arguments.until
    if arguments.dpi:
        style.DPI_GRAINS = style.DPI_CHAINS = arguments.dpi
    try:
        for name, needs, paths in pictures_of(arguments):
            drawn = 0
            for path in paths:
                print(path, flush=True)
                drawn += 1
            if not drawn:
                print(f"{name}: skipped, the run has no {needs}", flush=True)
    except BadRun as error:
        sys.exit(f"plot: {error}")
    return 0


if __name__ == "__main__":
    sys.exit(main())
