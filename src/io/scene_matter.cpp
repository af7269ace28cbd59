// What a scene is made of: materials, laws, grains, walls.
#include "io/scene_choice.hpp"
#include "io/scene_keys.hpp"
#include "io/scene_sections.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <limits>
#include <tuple>

namespace nappe::scene_file {

namespace {

/// Rules compare all pairs of them, of grains those that are near each other.
constexpr std::size_t most_materials = 100;
constexpr std::size_t most_laws = most_materials * (most_materials + 1) / 2 + most_materials;
constexpr std::size_t most_single_grains = 100'000;

template <class Named>
std::vector<std::string> names_of(const std::vector<Named>& things) {
    std::vector<std::string> names;
    names.reserve(things.size());
    for (const auto& thing : things) {
        names.push_back(thing.name);
    }
    return names;
}

/// Index of the thing a key names, or -1 and a problem.
int find_named(const TableReader& table, std::string_view key, std::string_view found_name,
               const std::vector<std::string>& names, std::string_view kind) {
    for (std::size_t i = 0; i < names.size(); ++i) {
        if (names[i] == found_name) {
            return static_cast<int>(i);
        }
    }
    const auto meant = nearest(found_name, names);
    table.problem(key,
                  fmt::format("must name a {} of the scene ({})", kind, names.empty() ? "it has none" : listed(names)),
                  meant ? fmt::format("did you mean {}?", *meant) : fmt::format("define the {} first", kind));
    return -1;
}

void read_material(const TableReader& table, const Scene<2>& scene, int& target, Need need) {
    std::string name;
    if (table.read("material", name, "name one of [materials]", need)) {
        target = find_named(table, "material", name, names_of(scene.materials), "material");
    }
}

/// The two materials of a law; false and a problem if they are not two known names.
bool read_pair(const TableReader& table, const Scene<2>& scene, ContactLaw& law) {
    constexpr auto remedy = "write between = [\"rock\", \"wall\"]";
    const auto* array = table.has("between") ? table.find("between")->as_array() : nullptr;
    if (array == nullptr || array->size() != 2 || !array->is_homogeneous<std::string>()) {
        table.problem("between", "must be two names of materials", remedy);
        return false;
    }
    const auto names = names_of(scene.materials);
    int* const targets[] = {&law.material_a, &law.material_b};
    for (std::size_t side = 0; side < 2; ++side) {
        const auto& name = array->get(side)->as_string()->get();
        const auto meant = nearest(name, names);
        const auto at = std::find(names.begin(), names.end(), name);
        if (at == names.end()) {
            table.problem(fmt::format("between.{}", side),
                          fmt::format("must name a material of the scene ({})", listed(names)),
                          meant ? fmt::format("did you mean {}?", *meant) : "define it under [materials]");
            return false;
        }
        *targets[side] = static_cast<int>(at - names.begin());
    }
    return true;
}

void read_radii(const TableReader& sample, RadiusLaw& radii) {
    const auto table =
        sample.table("radius", "sample.radius", "write { law = \"uniform\", min = …, max = … }", Need::required);
    std::string law;
    if (!table || !table->read("law", law, "write \"uniform\" or \"constant\"", Need::required)) {
        return;
    }
    const bool uniform = law == "uniform";
    if (!uniform && law != "constant") {
        table->problem("law", "must be \"uniform\" or \"constant\"", "uniform takes min and max, constant takes value");
        return;
    }
    for (const auto* other : {"min", "max", "value"}) {
        if (table->has(other) && uniform == (std::string_view(other) == "value")) {
            table->problem(other, fmt::format("must be absent with law = \"{}\"", law), "it would have no effect");
        }
    }
    if (!uniform) {
        radii.kind = RadiusLaw::Kind::constant;
        table->read("value", radii.min, positive("m", "give the radius in metres"), Need::required);
        radii.max = radii.min;
        return;
    }
    const bool min = table->read("min", radii.min, positive("m", "give the smallest radius in metres"), Need::required);
    const bool max = table->read("max", radii.max, positive("m", "give the largest radius in metres"), Need::required);
    if (min && max && radii.min > radii.max) {
        table->problem("min", fmt::format("must be <= sample.radius.max = {} [m]", radii.max), "exchange the two");
    }
}

/// Tops given one by one, or `count` equal layers.
void read_layers(const TableReader& sample, std::vector<double>& tops) {
    const auto* node = sample.find("layers");
    if (node == nullptr) {
        return;
    }
    constexpr auto remedy = "write { count = 9, from = 0, to = 30 } or the tops of the layers, as in [10, 20, 30]";
    if (node->is_array()) {
        sample.read("layers", tops, any_real("m", "give the heights of the layers' tops"));
        for (std::size_t k = 1; k < tops.size(); ++k) {
            if (!(tops[k - 1] < tops[k])) {
                sample.problem(fmt::format("layers.{}", k), fmt::format("must be > {} [m], the top below", tops[k - 1]),
                               "sort the tops from the lowest up");
                return;
            }
        }
        return;
    }
    if (!node->is_table()) {
        sample.problem("layers", "must be a table or an array of heights [m]", remedy);
        return;
    }
    const auto table = *sample.table("layers", "sample.layers", remedy);
    int count = 0;
    double from = 0;
    double to = 0;
    const bool counted = table.read("count", count, {1, "give the number of equal layers", 10000}, Need::required);
    const bool starts =
        table.read("from", from, any_real("m", "give the height of the lowest layer's foot"), Need::required);
    const bool ends = table.read("to", to, any_real("m", "give the height of the highest layer's top"), Need::required);
    if (starts && ends && !(from < to)) {
        table.problem("to", fmt::format("must be > sample.layers.from = {} [m]", from), "layers go upwards");
    } else if (counted && starts && ends) {
        for (int k = 1; k <= count; ++k) {
            tops.push_back(k == count ? to : from + (to - from) * k / count);
        }
    }
}

void read_motion(const TableReader& wall, const Scene<2>& scene, Wall<2>& target) {
    const auto table = wall.table("motion", "walls.motion", "write { stage = \"push\", velocity = [0.5, 0] }");
    if (!table) {
        return;
    }
    Motion<2> motion;
    table->read("velocity", motion.velocity, any_real("m/s", "give the velocity as [x, y]"), Need::required);
    table->read("start", motion.start, not_negative("s", "give the time of loading at which the wall starts"));
    table->read("stop", motion.stop, positive("s", "give the time of loading at which the wall stops"));
    if (table->has("stage") == table->has("start")) {
        table->problem(table->has("stage") ? "start" : "stage", "must be either a stage or a start time",
                       "give exactly one of motion.stage and motion.start");
        return;
    }
    double from = motion.start;
    std::string stage;
    if (table->read("stage", stage, "name one of [[stages]]")) {
        motion.stage = find_named(*table, "stage", stage, names_of(scene.stages), "stage");
        if (motion.stage >= 0 && scene.stages[static_cast<std::size_t>(motion.stage)].until) {
            table->problem("stage", "must be a stage with a duration", "walls rest while the sample is prepared");
        }
        for (int k = 0; k < motion.stage; ++k) {
            from += scene.stages[static_cast<std::size_t>(k)].duration;
        }
    }
    if (motion.stop && !(*motion.stop > from)) {
        table->problem("stop", fmt::format("must be > {} [s], when the wall starts", from), "times count from loading");
    }
    target.motion = motion;
}

RealRule gamma_rule() {
    return not_negative("N", "give the attraction of a pair per metre of depth, 0 for none");
}

RealRule d_w_rule() {
    return positive("m", "give the gap up to which a pair is bonded, 0.05 mean radii for example");
}

/// A parameter of a pair that its law does not give: that of the materials, if they do not contradict each other.
bool from_materials(const TableReader& table, std::string_view key, const std::optional<double>& of_a,
                    const std::optional<double>& of_b, double& target) {
    if (of_a && of_b && *of_a != *of_b) {
        table.problem(
            key, fmt::format("must be given where the two materials have different ones ({} and {})", *of_a, *of_b),
            "say which holds for the pair");
        return false;
    }
    if (!of_a && !of_b) {
        table.problem(key, "must be given in a cohesive law, or by one of its materials",
                      "give it, or write type = \"frictional\"");
        return false;
    }
    target = of_a ? *of_a : *of_b;
    return true;
}

void read_cohesion(const TableReader& table, const Scene<2>& scene, bool cohesive, ContactLaw& law) {
    if (!cohesive) {
        for (const auto* key : {"gamma", "d_w"}) {
            if (table.has(key)) {
                table.problem(key, "must be absent in a frictional law", "write type = \"cohesive\"");
            }
        }
        return;
    }
    const auto& a = scene.materials[static_cast<std::size_t>(law.material_a)];
    const auto& b = scene.materials[static_cast<std::size_t>(law.material_b)];
    const bool has_gamma = table.has("gamma") ? table.read("gamma", law.gamma, gamma_rule())
                                              : from_materials(table, "gamma", a.gamma, b.gamma, law.gamma);
    if (has_gamma && (law.gamma > 0 || table.has("d_w"))) { // without attraction there is no range to give
        if (table.has("d_w")) {
            table.read("d_w", law.d_w, d_w_rule());
        } else {
            from_materials(table, "d_w", a.d_w, b.d_w, law.d_w);
        }
    }
    if (law.gamma > 0 && law.restitution > 0) {
        table.problem("restitution", "must be 0 in a law with gamma > 0", "bonded pairs do not rebound");
    }
}

/// Springs are what smooth stages go by; rigid ones take the law's friction alone.
void read_springs(const TableReader& table, bool has_springs, ContactLaw& law) {
    if (!has_springs) {
        for (const auto* key : {"k_n", "k_s", "c_n", "c_s"}) {
            if (table.has(key)) {
                table.problem(key, "must be absent unless type = \"cundall\"", "write type = \"cundall\"");
            }
        }
        return;
    }
    Springs springs;
    table.read("k_n", springs.normal.k, positive("N/m", "give the stiffness of the normal spring"), Need::required);
    springs.tangential.k = springs.normal.k;
    table.read("k_s", springs.tangential.k, not_negative("N/m", "give the stiffness of the tangential spring"));
    table.read("c_n", springs.normal.c, not_negative("N s/m", "give the normal dashpot, or leave it out"));
    table.read("c_s", springs.tangential.c, not_negative("N s/m", "give the tangential dashpot, or leave it out"));
    if (law.restitution > 0) {
        table.problem("restitution", "must be absent in a law with springs", "dashpots say what an impact loses");
    }
    law.springs = springs;
}

} // namespace

void read_materials(const TableReader& top, Scene<2>& scene) {
    // Walls are made of this one unless they say otherwise.
    scene.materials.push_back({"wall", 0});
    for (const auto& [name, table] :
         top.named_tables("materials", "[materials.NAME]", "write [materials.rock]", most_materials)) {
        Material material{name, 0};
        table.read("density", material.density,
                   positive("kg/m³", "give the mass per area, or leave it out if only walls are made of it"));
        for (const auto& [key, value, rule] :
             {std::tuple("gamma", &material.gamma, gamma_rule()), std::tuple("d_w", &material.d_w, d_w_rule())}) {
            if (table.has(key) && !table.read(key, *value, rule)) {
                *value = 0; // given, so that its laws do not miss it as well
            }
        }
        table.read("damping", material.damping, not_negative("N s/m", "give C of its grains in smooth stages"));
        table.read("spin_damping", material.spin_damping,
                   not_negative("N m s", "give C* of its grains in smooth stages"));
        if (name == "wall") {
            scene.materials.front() = material;
        } else {
            scene.materials.push_back(material);
        }
    }
}

void read_laws(const TableReader& top, Scene<2>& scene) {
    for (const auto& table : top.tables("laws", "[[laws]]", "write [[laws]]", most_laws)) {
        ContactLaw law;
        std::string type;
        if (table.read("type", type, "write \"frictional\", \"cohesive\" or \"cundall\"", Need::required) &&
            type != "frictional" && type != "cohesive" && type != "cundall") {
            table.problem("type", "must be \"frictional\", \"cohesive\" or \"cundall\"",
                          "no other contact law is built");
        }
        table.read("friction", law.friction, not_negative("", "give the coefficient of Coulomb friction"),
                   Need::required);
        table.read("restitution", law.restitution, between(0, 1, "", "0 is inelastic, 1 loses nothing"));
        if (!read_pair(table, scene, law)) {
            continue;
        }
        read_cohesion(table, scene, type == "cohesive", law);
        read_springs(table, type == "cundall", law);
        if (find_law(scene, law.material_a, law.material_b) != nullptr) {
            table.problem("between",
                          fmt::format("must be the only law between {} and {}",
                                      scene.materials[static_cast<std::size_t>(law.material_a)].name,
                                      scene.materials[static_cast<std::size_t>(law.material_b)].name),
                          "remove one of the two");
            continue;
        }
        scene.laws.push_back(law);
    }
}

void read_sample(const TableReader& top, Scene<2>& scene) {
    const auto table = top.table("sample", "[sample]", "write [sample]");
    if (!table) {
        return;
    }
    Sample<2> sample;
    read_material(*table, scene, sample.material, Need::required);
    using Arrangement = Sample<2>::Arrangement;
    read_choice<Arrangement>(
        *table, "arrangement",
        {{"deposit", Arrangement::deposit}, {"square", Arrangement::square}, {"staggered", Arrangement::staggered}},
        sample.arrangement);
    read_radii(*table, sample.radii);
    table->read("profile", sample.profile, any_real("m", "give the corners of the sample in order"), Need::required);
    read_layers(*table, sample.layer_tops);
    std::int64_t seed = 1;
    table->read("seed", seed,
                {0, "give the number that radii are drawn from", std::numeric_limits<std::int64_t>::max()});
    sample.seed = static_cast<std::uint64_t>(seed);
    scene.sample = sample;
}

void read_grains(const TableReader& top, Scene<2>& scene) {
    for (const auto& table : top.tables("grains", "[[grains]]", "write [[grains]]", most_single_grains)) {
        SingleGrain<2> grain;
        read_material(table, scene, grain.material, Need::required);
        table.read("radius", grain.radius, positive("m", "give the radius in metres"), Need::required);
        table.read("position", grain.position, any_real("m", "give the centre as [x, y]"), Need::required);
        table.read("velocity", grain.velocity, any_real("m/s", "give the velocity as [x, y]"));
        table.read("spin", grain.spin[0], any_real("rad/s", "counter-clockwise is positive"));
        table.read("layer", grain.layer, {1, "layers are counted from 1"});
        table.read("drop", grain.drop, "true lets it come when loading starts, touching what lies below");
        scene.grains.push_back(grain);
    }
}

void read_walls(const TableReader& top, Scene<2>& scene) {
    for (const auto& table : top.tables("walls", "[[walls]]", "write [[walls]]")) {
        Wall<2> wall;
        wall.name = read_name(table, names_of(scene.walls), "wall");
        read_material(table, scene, wall.material, Need::optional);
        table.read("points", wall.points, any_real("m", "give the wall's points in order"), Need::required);
        read_motion(table, scene, wall);
        scene.walls.push_back(wall);
    }
}

} // namespace nappe::scene_file
