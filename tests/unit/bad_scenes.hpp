#pragma once
// Scenes that break one rule each, as an edit of sound_scene or as an override, with the whole message that they must
// give. A new rule of the reader gets a row here.

#include <string>
#include <vector>

namespace nappe::test {

struct BadScene {
    const char* name;
    const char* find;    ///< once in sound_scene; "" for no edit
    const char* replace; ///< by this
    std::vector<std::string> overrides;
    const char* message;
};

// clang-format off
inline const std::vector<BadScene> bad_scenes = {
    {"unknown_key", "theta = 0.6", "thetta = 0.6", {}, R"(bad.toml:57: solver.thetta: unknown key; must be one of those of [solver] (method, h, theta, sweeps, tolerance, max_sweeps, check_every, substeps), found "thetta"; did you mean theta?)"},
    {"unknown_key_far", "theta = 0.6", "colour = 3", {}, R"(bad.toml:57: solver.colour: unknown key; must be one of those of [solver] (method, h, theta, sweeps, tolerance, max_sweeps, check_every, substeps), found "colour"; remove it)"},
    {"unknown_table", "[balance]", "[ballance]", {}, R"(bad.toml:67: ballance: unknown key; must be one of those of the top level (title, world, materials, laws, sample, grains, walls, stages, solver, tiles, balance, output), found "ballance"; did you mean balance?)"},
    {"unknown_key_inline", "skin = 0.05", "skn = 0.05", {}, R"(bad.toml:65: tiles.skn: unknown key; must be one of those of [tiles] (side, skin, lookahead), found "skn"; did you mean skin?)"},
    {"unknown_key_in_motion", "stop = 8", "until = 8", {}, R"(bad.toml:42: walls.piston.motion.until: unknown key; must be one of those of walls.motion (stage, start, velocity, stop), found "until"; remove it)"},
    {"wrong_type_real", "h = 0.025", R"(h = "fast")", {}, R"(bad.toml:56: solver.h: must be > 0 [s] (a number), found "fast"; give the time step in seconds)"},
    {"wrong_type_integer", "sweeps = 80", "sweeps = 80.0", {}, "bad.toml:58: solver.sweeps: must be an integer >= 1, found 80.0; give the sweeps of a step; with a tolerance, the least"},
    {"wrong_type_string", R"(title = "box of disks")", "title = 3", {}, "bad.toml:1: title: must be a string, found 3; one line for pictures and logs"},
    {"wrong_type_table", "series = { every = 5 }", "series = 5", {}, "bad.toml:74: output.series: must be a table, found 5; write { every = 20 }"},
    {"wrong_type_tables", "[[grains]]", "[grains]", {}, "bad.toml:28: grains: must be an array of tables, found a table; write [[grains]]"},
    {"negative_radius", "min = 0.42", "min = -0.42", {}, "bad.toml:24: sample.radius.min: must be > 0 [m], found -0.42; give the smallest radius in metres"},
    {"zero_step", "h = 0.025", "h = 0", {}, "bad.toml:56: solver.h: must be > 0 [s], found 0; give the time step in seconds"},
    {"nan_friction", "friction = 0.3", "friction = nan", {}, "bad.toml:16: laws.1.friction: must be >= 0, found nan; give the coefficient of Coulomb friction"},
    {"infinite_density", "density = 2800.0", "density = inf", {}, "bad.toml:7: materials.rock.density: must be > 0 [kg/m³], found inf; give the mass per area, or leave it out if only walls are made of it"},
    {"infinite_coordinate", "[20, 5], [8, 5]", "[20, inf], [8, 5]", {}, "bad.toml:25: sample.profile.2.1: must be a finite number [m], found inf; give the corners of the sample in order"},
    {"three_coordinates", "position = [10, 12]", "position = [10, 12, 0]", {}, "bad.toml:31: grains.0.position: must be two numbers [x, y] [m], found an array of 3 values; give the centre as [x, y]"},
    {"step_missing", "h = 0.025\n", "", {}, "bad.toml:54: solver.h: is required and must be > 0 [s], found nothing; give the time step in seconds"},
    {"min_above_max", "min = 0.42", "min = 0.6", {}, "bad.toml:24: sample.radius.min: must be <= sample.radius.max = 0.56 [m], found 0.6; exchange the two"},
    {"radius_law", R"(law = "uniform")", R"(law = "normal")", {}, R"(bad.toml:24: sample.radius.law: must be "uniform" or "constant", found "normal"; uniform takes min and max, constant takes value)"},
    {"radius_value_idle", "max = 0.56", "max = 0.56, value = 0.5", {}, R"(bad.toml:24: sample.radius.value: must be absent with law = "uniform", found 0.5; it would have no effect)"},
    {"material_undefined", "[sample]\nmaterial = \"rock\"", "[sample]\nmaterial = \"rok\"", {}, R"(bad.toml:23: sample.material: must name a material of the scene (wall, rock, steel), found "rok"; did you mean rock?)"},
    {"material_weightless", "density = 2800.0\n", "", {}, "bad.toml:6: materials.rock.density: must be > 0 [kg/m³] where grains are made of the material, found nothing; give the density"},
    {"stage_undefined", R"(stage = "push")", R"(stage = "pull")", {}, R"(bad.toml:42: walls.piston.motion.stage: must name a stage of the scene (settle, push), found "pull"; define the stage first)"},
    {"stage_preparing", R"(stage = "push")", R"(stage = "settle")", {}, R"(bad.toml:42: walls.piston.motion.stage: must be a stage with a duration, found "settle"; walls rest while the sample is prepared)"},
    {"motion_stage_and_start", R"(stage = "push")", R"(stage = "push", start = 0)", {}, "bad.toml:42: walls.piston.motion.start: must be either a stage or a start time, found 0; give exactly one of motion.stage and motion.start"},
    {"motion_neither", R"(stage = "push", )", "", {}, "bad.toml:42: walls.piston.motion.stage: must be either a stage or a start time, found nothing; give exactly one of motion.stage and motion.start"},
    {"motion_stop_early", "start = 2, ", "start = 2, stop = 1, ", {}, "bad.toml:46: walls.lid.motion.stop: must be > 2 [s], when the wall starts, found 1; times count from loading"},
    {"law_missing", R"(between = ["rock", "wall"])", R"(between = ["steel", "wall"])", {}, R"(bad.toml:9: laws: must cover every pair of materials that can meet, found none between "rock" and "wall"; add [[laws]] with between = ["rock", "wall"])"},
    {"law_missing_among_grains", R"(between = ["rock", "rock"])", R"(between = ["steel", "wall"])", {}, R"(bad.toml:9: laws: must cover every pair of materials that can meet, found none between "rock" and "rock"; add [[laws]] with between = ["rock", "rock"])"},
    {"law_missing_between_kinds", "", "", {"grains.0.material=steel", "materials.steel.density=7800"}, "bad.toml:9: laws: must cover every pair of materials that can meet, found none between \"steel\" and \"wall\"; add [[laws]] with between = [\"steel\", \"wall\"]\n" R"(bad.toml:9: laws: must cover every pair of materials that can meet, found none between "steel" and "steel"; add [[laws]] with between = ["steel", "steel"])"},
    {"law_duplicate", R"(between = ["rock", "wall"])", R"(between = ["rock", "steel"])", {}, "bad.toml:19: laws.2.between: must be the only law between rock and steel, found an array of 2 values; remove one of the two"},
    {"law_type", "[\"rock\", \"rock\"]\ntype = \"frictional\"", "[\"rock\", \"rock\"]\ntype = \"cohesive\"", {}, R"(bad.toml:11: laws.0.type: must be "frictional", found "cohesive"; no other contact law is built)"},
    {"law_material", R"(between = ["rock", "wall"])", R"(between = ["rock", "wal"])", {}, R"(bad.toml:19: laws.2.between.1: must name a material of the scene (wall, rock, steel), found "wal"; did you mean wall?)"},
    {"law_pair", R"(between = ["rock", "wall"])", R"(between = "rock")", {}, R"(bad.toml:19: laws.2.between: must be two names of materials, found "rock"; write between = ["rock", "wall"])"},
    {"friction_negative", "friction = 0.3", "friction = -0.3", {}, "bad.toml:16: laws.1.friction: must be >= 0, found -0.3; give the coefficient of Coulomb friction"},
    {"restitution_large", "restitution = 0.5", "restitution = 1.5", {}, "bad.toml:17: laws.1.restitution: must lie in [0, 1], found 1.5; 0 is inelastic, 1 loses nothing"},
    {"wall_name_twice", R"(name = "lid")", R"(name = "floor")", {}, R"(bad.toml:44: walls.2.name: must be the only wall of that name, found "floor"; rename one of them)"},
    {"cell_name_twice", R"(name = "W2")", R"(name = "W1")", {}, R"(bad.toml:75: output.cells.1.name: must be the only cell of that name, found "W1"; rename one of them)"},
    {"stage_name_twice", "name = \"push\"\nduration", "name = \"settle\"\nduration", {}, "bad.toml:42: walls.piston.motion.stage: must name a stage of the scene (settle, settle), found \"push\"; define the stage first\n" R"(bad.toml:52: stages.1.name: must be the only stage of that name, found "settle"; rename one of them)"},
    {"name_unfit", R"(name = "lid")", R"(name = "../lid")", {}, R"(bad.toml:44: walls.2.name: must be 1 to 64 letters, digits, _ or -, found "../lid"; files are named after it)"},
    {"name_missing", "name = \"lid\"\n", "", {}, "bad.toml:43: walls.2.name: is required and must be a string, found nothing; name the wall: files and --set use the name"},
    {"wall_one_point", "[[25, 0], [25, 30]]", "[[25, 0]]", {}, "bad.toml:45: walls.lid.points: must be at least 2 points, found 1; a wall is a line"},
    {"wall_zero_segment", "[[25, 0], [25, 30]]", "[[25, 0], [25, 0], [25, 30]]", {}, "bad.toml:45: walls.lid.points.1: must differ from the point before it, found [25, 0] twice; remove one"},
    {"wall_in_profile", "[[25, 0], [25, 30]]", "[[15, 1], [15, 30]]", {}, "bad.toml:45: walls.lid.points.0: must stay out of sample.profile, found the segment from [15, 1] to [15, 30] at least 2 m inside; move the wall, or cut it out of the profile"},
    {"profile_two_points", "[[0, 0], [20, 0], [20, 5], [8, 5], [5, 10], [0, 10]]", "[[0, 0], [20, 0]]", {}, "bad.toml:25: sample.profile: must be at least 3 points, found 2; give the corners of the sample in order"},
    {"profile_flat", "[[0, 0], [20, 0], [20, 5], [8, 5], [5, 10], [0, 10]]", "[[0, 0], [20, 0], [10, 0]]", {}, "bad.toml:25: sample.profile: must enclose an area > 0 [m²], found all points on one line; check the corners"},
    {"profile_closed_twice", "[5, 10], [0, 10]]", "[5, 10], [0, 10], [0, 0]]", {}, "bad.toml:25: sample.profile.6: must differ from the first point, found [0, 0] again; remove it, the polygon closes by itself"},
    {"profile_crossing", "[[0, 0], [20, 0], [20, 5], [8, 5], [5, 10], [0, 10]]", "[[0, 0], [20, 5], [20, 0], [0, 5]]", {}, "bad.toml:25: sample.profile.2: must not cross or touch itself, found edges 0 and 2 (from 0) meeting; give the corners in order around the sample"},
    {"profile_thin", "[[0, 0], [20, 0], [20, 5], [8, 5], [5, 10], [0, 10]]", "[[0, 0], [20, 0], [20, 1], [0, 1]]", {}, "bad.toml:25: sample.profile: must have room for a grain of the largest radius, 0.56 [m], found it too narrow everywhere (area 20 m²); widen it or use smaller grains"},
    {"profile_fold_back", "[[0, 0], [20, 0], [20, 5], [8, 5], [5, 10], [0, 10]]", "[[0, 0], [20, 0], [10, 0], [10, 5], [0, 5]]", {}, "bad.toml:25: sample.profile.1: must not cross or touch itself, found edges 0 and 1 (from 0) meeting; give the corners in order around the sample"},
    {"grain_in_profile", "position = [10, 12]", "position = [10, 5.4]", {}, "bad.toml:31: grains.0.position: must keep the grain out of sample.profile, found [10, 5.4] with radius 0.5 [m]; move it"},
    {"grain_on_wall", "position = [10, 12]", "position = [25.1, 12]", {}, R"(bad.toml:31: grains.0.position: must be at least half a radius (0.25 m) from every wall, found 0.1 m from "lid"; move the grain or the wall)"},
    {"grains_coincide", "layer = 4", "layer = 4\n[[grains]]\nmaterial=\"rock\"\nradius=0.3\nposition=[10.4, 12]", {}, "bad.toml:38: grains.1.position: must lie outside the other grains, found its centre or that of grain 0 (from 0) inside the other; move one of them"},
    {"far_away", "position = [10, 12]", "position = [1e9, 12]", {}, "bad.toml:31: grains.0.position: must lie within 1e7 smallest radii (4.2e+06 m) of [0, 0], found [1000000000, 12]; shift the scene"},
    {"theta_small", "theta = 0.6", "theta = 0.4", {}, "bad.toml:57: solver.theta: must lie in [0.5, 1], found 0.4; 0.5 keeps energy, 1 damps most"},
    {"sweeps_none", "sweeps = 80", "sweeps = 0", {}, "bad.toml:58: solver.sweeps: must be an integer >= 1, found 0; give the sweeps of a step; with a tolerance, the least"},
    {"sweeps_above_most", "max_sweeps = 500", "max_sweeps = 50", {}, "bad.toml:50: stages.settle.solver.sweeps: must be <= max_sweeps = 50 with a tolerance, found 300; raise max_sweeps or lower sweeps\n" "bad.toml:60: solver.max_sweeps: must be >= sweeps = 80 with a tolerance, found 50; raise max_sweeps or lower sweeps"},
    {"tolerance_missing", "tolerance = 1e-5\n", "", {}, "bad.toml:59: solver.max_sweeps: must be absent without a tolerance, found 500; add tolerance, or remove this key: it has no effect\n" "bad.toml:60: solver.check_every: must be absent without a tolerance, found 20; add tolerance, or remove this key: it has no effect"},
    {"method", R"("nsgs")", R"("jacobi")", {}, R"(bad.toml:55: solver.method: must be "nsgs", found "jacobi"; no other solver is built)"},
    {"stage_both", "duration = 10", "duration = 10\nuntil = {}", {}, "bad.toml:53: stages.push.duration: must be either a criterion or a duration, found 10; give exactly one of until and duration"},
    {"stage_neither", "duration = 10\n", "", {}, "bad.toml:51: stages.push.until: must be either a criterion or a duration, found nothing; give exactly one of until and duration"},
    {"stage_order", "duration = 10", "duration = 10\n[[stages]]\nname = \"rest\"\nuntil = {}", {}, "bad.toml:56: stages.rest.until: must come before every stage with a duration, found a table; preparing stages come first; move this one up"},
    {"stages_none", "[[stages]]\nname = \"settle\"\nuntil = { kinetic = 1e-7, residual = 1e-3, at_most = 50 }\nsolver = { h = 0.01, sweeps = 300 }\n[[stages]]\nname = \"push\"\nduration = 10\n", "", {"walls.piston.motion={start=0,velocity=[1,0]}"}, "bad.toml: stages: must hold at least one stage, found nothing; write [[stages]] with a name and a duration or until"},
    {"layers_count", "layers = { count = 3, from = 0, to = 4.5 }", "layers = 9", {}, "bad.toml:26: sample.layers: must be a table or an array of heights [m], found 9; write { count = 9, from = 0, to = 30 } or the tops of the layers, as in [10, 20, 30]"},
    {"layers_descending", "layers = { count = 3, from = 0, to = 4.5 }", "layers = [1, 3, 2]", {}, "bad.toml:26: sample.layers.2: must be > 3 [m], the top below, found 2; sort the tops from the lowest up"},
    {"layers_upside_down", "layers = { count = 3, from = 0, to = 4.5 }", "layers = { count = 3, from = 4.5, to = 0 }", {}, "bad.toml:26: sample.layers.to: must be > sample.layers.from = 4.5 [m], found 0; layers go upwards"},
    {"tile_small", "side = 8", "side = 2.3", {}, "bad.toml:64: tiles.side: side must be > 2 (2 r_max + skin + d_w) = 2.34 [m], found side 2.3 with skin 0.05, d_w 0 and r_max 0.56; give a wider side or a smaller skin"},
    {"threshold", "threshold = 1.1", "threshold = 0.9", {}, "bad.toml:68: balance.threshold: must be >= 1, found 0.9; largest over mean load per rank; 1.01 is usual"},
    {"balance_by", R"(by = "time")", R"(by = "luck")", {}, R"(bad.toml:70: balance.by: must be "work" or "time", found "luck"; write "work" or "time")"},
    {"balance_moves", R"(moves = "always")", R"(moves = "never")", {}, R"(bad.toml:71: balance.moves: must be "when_it_pays" or "always", found "never"; write "when_it_pays" or "always")"},
    {"series_zero", "series = { every = 5 }", "series = { every = 0 }", {}, "bad.toml:74: output.series.every: must be an integer >= 1, found 0; give it in steps"},
    {"measures_range", "range = 4", "range = 1", {}, "bad.toml:77: output.measures.range: must be >= output.measures.spacing = 2 [m], found 1; raise it to two spacings, or choose a finer grid"},
    {"measures_flag", "during_run = true", "during_run = 1", {}, "bad.toml:77: output.measures.during_run: must be true or false, found 1; true measures at every frame of the run"},
    {"zone_wall", R"(zone = { wall = "piston")", R"(zone = { wall = "pistn")", {}, R"(bad.toml:78: output.zone.wall: must name a wall of the scene (floor, piston, lid), found "pistn"; did you mean piston?)"},
    {"zone_wall_at_rest", R"(zone = { wall = "piston")", R"(zone = { wall = "floor")", {}, R"(bad.toml:78: output.zone.wall: must be a wall with a motion, found "floor"; limits are sought against the speed of the wall that drives)"},
    {"zone_tip_missing", "tip = [6, 0.5], ", "", {}, "bad.toml:78: output.zone.tip: is required and must be two numbers [x, y], found nothing; give the fault tip when loading starts as [x, y]"},
    {"zone_tolerance", "tolerance = 0.2", "tolerance = 0.7", {}, "bad.toml:78: output.zone.tolerance: must lie in (0, 0.5], found 0.7; give the share of the wall's speed, 0.1 is usual"},
    {"seed_negative", "seed = 7", "seed = -7", {}, "bad.toml:27: sample.seed: must be an integer >= 0, found -7; give the number that radii are drawn from"},
    {"dimension_three", "dimension = 2", "dimension = 3", {}, "bad.toml:3: world.dimension: must be 2, found 3; only scenes in the plane are built; leave it out or write 2"},
    {"syntax", "friction = 0.3", "friction = 0..3", {}, "bad.toml:16: must be valid TOML: Error while parsing floating-point: expected decimal digit or exponent, saw '.' (column 14); see https://toml.io"},
    {"duplicate_key", "h = 0.025", "h = 0.025\nh = 0.02", {}, "bad.toml:57: must be valid TOML: Error while parsing key-value pair: cannot redefine existing floating-point 'h' (column 5); see https://toml.io"},
    {"duplicate_table", "[balance]", "[tiles]", {}, "bad.toml:67: must be valid TOML: Error while parsing table header: cannot redefine existing table 'tiles' (column 1); see https://toml.io"},
    {"two_errors", "theta = 0.6", "theta = 2", {"tiles.skn=1"}, "--set tiles.skn=1: tiles.skn: unknown key; must be one of those of [tiles] (side, skin, lookahead), found \"skn\"; did you mean skin?\n" "bad.toml:57: solver.theta: must lie in [0.5, 1], found 2; 0.5 keeps energy, 1 damps most"},
    {"override_value", "", "", {"solver.h=-1"}, "--set solver.h=-1: solver.h: must be > 0 [s], found -1; give the time step in seconds"},
    {"override_unknown", "", "", {"solver.hh=1"}, R"(--set solver.hh=1: solver.hh: unknown key; must be one of those of [solver] (method, h, theta, sweeps, tolerance, max_sweeps, check_every, substeps), found "hh"; remove it)"},
    {"override_unknown_table", "", "", {"solvr.h=1"}, R"(--set solvr.h=1: solvr: unknown key; must be one of those of the top level (title, world, materials, laws, sample, grains, walls, stages, solver, tiles, balance, output), found "solvr"; did you mean solver?)"},
    {"override_no_element", "", "", {"walls.pistn.motion.velocity=[1,0]"}, R"(--set walls.pistn.motion.velocity=[1,0]: walls.pistn: must name an element of walls (floor, piston, lid) or give its index from 0, found "pistn"; did you mean piston?)"},
    {"override_no_index", "", "", {"laws.3.friction=0.1"}, R"(--set laws.3.friction=0.1: laws.3: must name an element of laws (0, 1, 2) or give its index from 0, found "3"; add it in the file, or replace the whole array)"},
    {"override_below_number", "", "", {"solver.h.x=1"}, R"(--set solver.h.x=1: solver.h: must be a table or an array to hold "x", found 0.025; shorten the key)"},
    {"override_not_toml", "", "", {"solver.h=0..1"}, R"(--set solver.h=0..1: the value must be TOML on one line (0.5, true, [1, 0], { every = 10 }, "text" or a bare word), found "0..1"; mind the shell's own quotes)"},
    {"override_no_value", "", "", {"solver.h="}, R"(--set solver.h=: the value must be TOML on one line (0.5, true, [1, 0], { every = 10 }, "text" or a bare word), found nothing; mind the shell's own quotes)"},
    {"override_no_equals", "", "", {"solver.h"}, R"(--set solver.h: must be KEY=VALUE with a dotted KEY of letters, digits, _ and -, found "solver.h"; for example --set solver.h=0.01 or walls.piston.motion.velocity=[1,0])"},
    {"override_bad_key", "", "", {"solver..h=1"}, R"(--set solver..h=1: must be KEY=VALUE with a dotted KEY of letters, digits, _ and -, found "solver..h=1"; for example --set solver.h=0.01 or walls.piston.motion.velocity=[1,0])"},
    {"override_two_lines", "", "", {"solver.h=1\ntheta=1"}, R"(--set solver.h=1 theta=1: the value must be TOML on one line (0.5, true, [1, 0], { every = 10 }, "text" or a bare word), found "1 theta=1"; mind the shell's own quotes)"},
    {"override_element_type", "", "", {"world.gravity.1=down"}, R"(--set world.gravity.1=down: world.gravity.1: must be a finite number [m/s²] (a number), found "down"; give [0, -9.81] for the Earth's)"},
};
// clang-format on

} // namespace nappe::test
