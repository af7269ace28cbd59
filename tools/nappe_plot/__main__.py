"""tools/plot: draws the pictures of a run and prints their paths."""

import argparse
import sys
from pathlib import Path

from . import cells, chains, curves, layers, solver, style
from .run import BadRun, Run

# In the order of drawing: a name for --only, what draws it, and what a run must have for it.
PICTURES = {
    "layers": (layers.draw, "frames"),
    "zoom": (layers.draw_zoom, "frames"),
    "stress": (curves.draw_stress, "series of cells"),
    "lambda": (curves.draw_lambda, "series of cells"),
    "front": (curves.draw_front, "the series front and a wall that moves"),
    "cells": (cells.draw, "cells with grains"),
    "chains": (chains.draw, "contacts with an impulse in the frames chosen"),
    "solver": (solver.draw, "the series solver"),
}


def times(text):
    try:
        return [float(part) for part in text.split(",")]
    except ValueError:
        raise argparse.ArgumentTypeError(f'times are numbers [s] with commas between them; found "{text}"') from None


def names(text):
    chosen = text.split(",")
    unknown = [name for name in chosen if name not in PICTURES]
    if unknown:
        raise argparse.ArgumentTypeError(f'no picture "{unknown[0]}"; there are {", ".join(PICTURES)}')
    return chosen


def main():
    parser = argparse.ArgumentParser(prog="tools/plot", description="Draws the pictures of a run.")
    parser.add_argument("dir", metavar="DIR", type=Path, help="what nappe run --out wrote")
    parser.add_argument("--times", type=times, help="of the frames to draw [s]: 0,200,350,500; the nearest are taken")
    parser.add_argument("--out", type=Path, help="where the pictures go (DIR/pictures)")
    parser.add_argument("--only", type=names, default=list(PICTURES), help=f"some of {', '.join(PICTURES)}")
    parser.add_argument("--dpi", type=int, help="of the pictures of grains, which are 16 inches wide (300)")
    arguments = parser.parse_args()
    style.apply()
    if arguments.dpi:
        style.DPI_GRAINS = style.DPI_CHAINS = arguments.dpi
    try:
        run = Run(arguments.dir)
        chosen = run.choose(arguments.times)
        out = arguments.out or run.folder / "pictures"
        for name in arguments.only:
            draw, needs = PICTURES[name]
            drawn = 0
            for path in draw(run, chosen, out):
                print(path, flush=True)
                drawn += 1
            if not drawn:
                print(f"{name}: skipped, the run has no {needs}", flush=True)
    except BadRun as error:
        sys.exit(f"plot: {error}")
    return 0


if __name__ == "__main__":
    sys.exit(main())
