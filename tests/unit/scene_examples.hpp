#pragma once
// A small sound scene that uses every key once, for tests that break it.

#include <string_view>

namespace nappe::test {

inline constexpr std::string_view sound_scene = R"(title = "box of disks"
[world]
dimension = 2
gravity = [0, -9.81]
origin = [-1.5, 0.0]
[materials.rock]
density = 2800.0
[materials.steel]
[[laws]]
between = ["rock", "rock"]
type = "frictional"
friction = 0.4
[[laws]]
between = ["steel", "rock"]
type = "frictional"
friction = 0.3
restitution = 0.5
[[laws]]
between = ["rock", "wall"]
type = "frictional"
friction = 0
[sample]
material = "rock"
radius = { law = "uniform", min = 0.42, max = 0.56 }
profile = [[0, 0], [20, 0], [20, 5], [8, 5], [5, 10], [0, 10]]
layers = { count = 3, from = 0, to = 4.5 }
seed = 7
[[grains]]
material = "rock"
radius = 0.5
position = [10, 12]
velocity = [0, -1]
spin = 2.5
layer = 4
drop = false
[[walls]]
name = "floor"
points = [[0, 0], [20, 0]]
[[walls]]
name = "piston"
material = "steel"
points = [[0, 20], [0, 0]]
motion = { stage = "push", velocity = [0.5, 0.0], stop = 8 }
[[walls]]
name = "lid"
points = [[25, 0], [25, 30]]
motion = { start = 2, velocity = [0, 0.1] }
[[stages]]
name = "settle"
until = { kinetic = 1e-7, residual = 1e-3, at_most = 50 }
solver = { h = 0.01, sweeps = 300 }
[[stages]]
name = "push"
duration = 10
[solver]
method = "nsgs"
h = 0.025
theta = 0.6
sweeps = 80
tolerance = 1e-5
max_sweeps = 500
check_every = 20
substeps = 2
[tiles]
side = 8
skin = 0.05
lookahead = 4
large_above = 1.5
[balance]
threshold = 1.1
every = 100
by = "time"
moves = "always"
[output]
frames = { every = 40 }
series = { every = 5 }
cells = [{ name = "W1", centre = [3, 3], radius = 2 }, { name = "W2", centre = [9, 2], radius = 1.5 }]
front_bin = 1.5
measures = { during_run = true, spacing = 2, range = 4, energy = true }
zone = { wall = "piston", tip = [6, 0.5], tolerance = 0.2 }
[watch]
overlap = { limit = 0.2, do = "substep" }
energy = { limit = 0.05, do = "stop" }
residual = { steps = 3, do = "stop" }
bounds = { min = [-1, -2], max = [30, 40], do = "warn" }
failure = { do = "substep" }
max_substeps = 16
[[output.gauges]]
name = "slab"
wall = "floor"
from = 2
bins = 9
every = 3
[[output.gauges]]
name = "shove"
wall = "piston"
[[output.probes]]
name = "one"
grain = 12345678901
every = 7
[[output.probes]]
name = "two"
grain = 0
)";

} // namespace nappe::test
