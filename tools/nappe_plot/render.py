"""tools/render: the layers drawn by ParaView from DIR/run.xdmf. Run by pvpython, under an X display."""

import argparse
import sys
from pathlib import Path

from nappe_plot import palette
from paraview import simple

LAYERS_DRAWN = 16  # colours are given for this many layers


def open_run(path):
    """The reader of run.xdmf and its times [s]. ParaView 5.11 wants an absolute path, or one that starts with ./."""
    reader = simple.OpenDataFile(str(path))
    reader.UpdatePipelineInformation()
    values = reader.TimestepValues
    times = list(values) if hasattr(values, "__iter__") else [values]
    if times:
        reader.UpdatePipeline(times[0])
    arrays = reader.PointData.keys()
    missing = [name for name in ("radius", "layer") if name not in arrays]
    if not times or missing:
        sys.exit(
            f"render: {path} needs the arrays radius and layer at one time at least; ParaView finds {len(times)} times "
            f"and the arrays {list(arrays)}"
        )
    return reader, times


def show(reader, view):
    """A ball per grain, of its radius, in its layer's colour; flat, since the scene is one of disks."""
    balls = simple.Glyph(Input=reader, GlyphType="Sphere", GlyphMode="All Points")
    balls.ScaleArray = ["POINTS", "radius"]
    balls.ScaleFactor = 2.0  # ParaView's ball has radius 1/2
    balls.GlyphType.ThetaResolution = 12
    balls.GlyphType.PhiResolution = 7
    shown = simple.Show(balls, view)
    simple.ColorBy(shown, ("POINTS", "layer"))
    colours = simple.GetColorTransferFunction("layer")
    colours.InterpretValuesAsCategories = 1
    colours.Annotations = [text for k in range(1, LAYERS_DRAWN + 1) for text in (str(k), str(k))]
    table = [palette.layer_colour(k, len(palette.BED)) for k in range(1, LAYERS_DRAWN + 1)]
    colours.IndexedColors = [part for colour in table for part in palette.rgb(colour)]
    shown.Ambient, shown.Diffuse, shown.Specular = 0.55, 0.5, 0.0
    return balls


def aim(view, bounds, width):
    """Looks straight at the plane; the picture has the shape of the bounds (x_min, x_max, y_min, y_max)."""
    x_min, x_max, y_min, y_max = bounds
    margin = 0.02 * (x_max - x_min)
    across, up = x_max - x_min + 2 * margin, y_max - y_min + 2 * margin
    height = max(200, int(width * up / across))
    middle = [(x_min + x_max) / 2, (y_min + y_max) / 2]
    view.ViewSize = [width, height]
    view.CameraParallelProjection = 1
    view.CameraFocalPoint = [*middle, 0.0]
    view.CameraPosition = [*middle, 10.0 * across]
    view.CameraViewUp = [0.0, 1.0, 0.0]
    view.CameraParallelScale = max(up, across * height / width) / 2
    return [width, height]


def times(text):
    return [float(part) for part in text.split(",")]


def main():
    parser = argparse.ArgumentParser(prog="tools/render", description="Draws the layers with ParaView.")
    parser.add_argument("dir", metavar="DIR", type=Path, help="what nappe run --out wrote")
    parser.add_argument("--times", type=times, help="of the frames to draw [s]; the nearest are taken")
    parser.add_argument("--out", type=Path, help="where the pictures go (DIR/pictures)")
    parser.add_argument("--width", type=int, default=2400, help="pixels")
    arguments = parser.parse_args()
    folder = arguments.dir.resolve()
    if not (folder / "run.xdmf").is_file():
        sys.exit(f"render: {folder} holds no run.xdmf; give the folder that `nappe run --out` wrote")
    out = arguments.out or folder / "pictures"
    out.mkdir(parents=True, exist_ok=True)

    reader, at = open_run(folder / "run.xdmf")
    view = simple.CreateView("RenderView")
    view.Background = [1.0, 1.0, 1.0]
    view.UseColorPaletteForBackground = 0
    view.OrientationAxesVisibility = 0
    simple._DisableFirstRenderCameraReset()  # the camera is set below
    show(reader, view)
    label = simple.Text(Text="")
    shown = simple.Show(label, view)
    shown.Color = palette.rgb(palette.INK)
    shown.FontSize = 30
    shown.WindowLocation = "Upper Right Corner"
    first, last = at[0], at[-1]
    wanted = arguments.times or [first, first + 0.4 * (last - first), first + 0.7 * (last - first), last]
    chosen = sorted({min(at, key=lambda t, w=w: abs(t - w)) for w in wanted})  # as tools/plot chooses
    bounds = None
    for time in chosen:
        reader.UpdatePipeline(time)
        here = reader.GetDataInformation().GetBounds()[:4]
        bounds = here if bounds is None else [f(a, b) for f, a, b in zip((min, max) * 2, bounds, here)]
    size = aim(view, bounds, arguments.width)
    for time in chosen:
        view.ViewTime = time
        label.Text = f"t = {time:.4g} s"
        simple.Render(view)
        path = out / f"paraview-{time:04.0f}s.png"
        simple.SaveScreenshot(str(path), view, ImageResolution=size)
        print(path, flush=True)


if __name__ == "__main__":
    main()
