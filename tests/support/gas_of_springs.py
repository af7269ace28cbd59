"""A scene of loose disks on springs in a box that shakes them: contacts come and go all the time, tiles lie alone among
empty ones, and ranks share grains that they hardly touch."""

import random

LAW = """
[[laws]]
between = ["rock", "{other}"]
type = "cundall"
friction = 0.4
k_n = 1e6
c_n = 0.0
c_s = 0.0
"""


def row(n):
    """Text of the scene: a row of disks that press each other, one of them with a push, nothing to stop what goes through
    it: energy seems to grow here and shrink there. A frame each step."""
    text = 'title = "row"\n[world]\ngravity = [0, 0]\n[materials.rock]\ndensity = 2000\n' + LAW.format(other="rock")
    for i in range(n):
        text += f'[[grains]]\nmaterial = "rock"\nradius = 0.05\nposition = [{0.0995 * i:.4f}, 0]\n'
        text += f"velocity = [{1.0 if i == 0 else 0.0}, 0]\n"
    text += '[[stages]]\nname = "push"\nduration = 0.02\nsolver = { method = "cundall", h = 1e-4 }\n[solver]\nh = 1e-4\n'
    return text + "[output]\nseries = { every = 1 }\nframes = { every = 1 }\n[tiles]\nside = 0.25\nskin = 0.02\n"


def gas(columns, rows, spacing, seed):
    """Text of the scene. @param spacing of the lattice that somewhat more than half of the disks stand on, over their
    largest radius"""
    rng = random.Random(seed)
    r_max = 0.05
    step = spacing * r_max
    text = 'title = "gas of springs"\n[world]\ngravity = [1, -2]\n[materials.rock]\ndensity = 2000\ndamping = 3\n'
    text += LAW.format(other="rock") + LAW.format(other="wall")
    for j in range(rows):
        for i in range(columns):
            if rng.random() < 0.45:
                continue
            text += '[[grains]]\nmaterial = "rock"\n'
            text += f"radius = {r_max * rng.uniform(0.5, 1):.4f}\n"
            text += f"position = [{step * (i + 0.5):.4f}, {step * (j + 0.5):.4f}]\n"
            text += f"velocity = [{rng.uniform(-3, 3):.3f}, {rng.uniform(-3, 3):.3f}]\n"
    w, h = step * columns, step * rows
    corners = [[0, h], [0, 0], [w, 0], [w, h], [0, h]]
    text += f'[[walls]]\nname = "box"\npoints = {[[round(v, 6) for v in p] for p in corners]}\n'
    text += '[[stages]]\nname = "fly"\nduration = 0.5\nsolver = { method = "cundall", h = 1e-4 }\n[solver]\nh = 1e-4\n'
    text += "[output]\nseries = { every = 100 }\nframes = { every = 1000 }\n"
    return text + "[tiles]\nside = 0.25\nskin = 0.02\nlookahead = 1\n[balance]\nevery = 100\n"
