"""The pictures that docs/rockfall.md shows, as small as a page wants them."""

import shutil
import subprocess
from pathlib import Path

from PIL import Image

from . import plan
from .results import UNTIL

TOOLS = Path(__file__).resolve().parents[1]
CURVES = 1100, 64  # pixels, colours
GRAINS = 800, 24
AMORPHOUS = ["1-10-c", *plan.LATTICES]
PEAK = 0.01  # s: a stored frame at which P1 is near its peak in all arrangements
TIMES = "0.01,0.02,0.03"


def _plot(*arguments):
    subprocess.run([TOOLS / "plot", *map(str, arguments)], check=True, capture_output=True, text=True)


def shrink(path, size):
    """To a page's width [pixels] and number of colours."""
    width, colours = size
    picture = Image.open(path).convert("RGB")
    picture = picture.resize((width, round(picture.height * width / picture.width)), Image.Resampling.LANCZOS)
    picture = picture.quantize(colours, method=Image.Quantize.FASTOCTREE, kmeans=2, dither=Image.Dither.NONE)
    picture.save(path, optimize=True)
    return path


def _compare(results, names, only, out, target, *arguments, size=CURVES):
    names = [name for name in names if name in results and results[name].summary]
    if not names:
        return
    folders = [results[name].folder for name in names]
    _plot("--compare", *folders, "--labels", ",".join(names), "--only", only, "--out", out, *arguments)
    shutil.move(out / f"{only}.png", out / target)
    yield shrink(out / target, size)


def pictures(results, out):
    out.mkdir(parents=True, exist_ok=True)
    early = "--until", UNTIL
    yield from _compare(results, ["1-10"], "penetration", out, "rockfall-penetration-1-10.png")
    yield from _compare(results, plan.ROWS[1:], "penetration", out, "rockfall-penetration.png")
    yield from _compare(results, plan.ROWS, "gauges", out, "rockfall-gauges.png", *early)
    yield from _compare(results, AMORPHOUS, "penetration", out, "rockfall-arrangements-penetration.png", *early)
    yield from _compare(results, AMORPHOUS, "gauges", out, "rockfall-arrangements-gauges.png", *early)
    chains = "chains", out, "rockfall-chains.png", "--times", PEAK, "--dpi", 140
    yield from _compare(results, AMORPHOUS, *chains, size=GRAINS)
    both = [f"{depth}-10-{kind}" for depth in ("0.5", "1") for kind in ("c", "c-free-rock", "c-undamped", "rigid")]
    yield from _compare(results, both, "penetration", out, "rockfall-rigid-penetration.png")
    for name in AMORPHOUS:
        if name in results and results[name].summary:
            _plot(results[name].folder, "--only", "impact", "--times", TIMES, "--out", out, "--dpi", 140)
            target = out / f"rockfall-impact-{name}.png"
            shutil.move(out / "impact.png", target)
            yield shrink(target, GRAINS)
