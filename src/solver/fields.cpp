#include "solver/fields.hpp"

#include "core/contact_set.hpp"
#include "solver/disk_batch.hpp"

namespace nappe {

namespace {

template <class Owner, class T>
constexpr std::size_t row_of(std::vector<T> Owner::*) {
    return sizeof(T);
}

template <class Batch>
constexpr std::size_t lane_of = sizeof(Batch) / n_lanes;

} // namespace

std::vector<Field> fields_of(const Features& f) {
    using S = State<2>;
    using C = CandidateSet<2>;
    using enum Field::Per;
    const auto of_state = [](const char* name, std::size_t bytes, const char* holds, const char* asked_by = "",
                             bool carried = true) {
        return Field{grain, name, bytes, holds, asked_by, carried, "State"};
    };
    const auto of_set = [](const char* name, std::size_t bytes, const char* holds, const char* asked_by = "",
                           bool carried = true) {
        return Field{candidate, name, bytes, holds, asked_by, carried, "CandidateSet"};
    };
    const auto of_lanes = [](const char* name, std::size_t bytes, const char* holds, const char* asked_by = "",
                             bool carried = true) {
        return Field{packed, name, bytes, holds, asked_by, carried, "DiskContacts"};
    };
    return {
        of_state("id", row_of(&S::id), "name"),
        of_state("x", row_of(&S::x), "position"),
        of_state("mid", row_of(&S::mid), "place of detection and radius, as kernels load them"),
        of_state("x_ref", row_of(&S::x_ref), "position at the last rebuild"),
        of_state("margin", row_of(&S::margin), "way to go before the next"),
        of_state("u", row_of(&S::u), "velocity, rim speed, 1/mass, as kernels load them"),
        of_state("u_old", row_of(&S::u_old), "the same at the start of the step"),
        of_state("radius", row_of(&S::radius), "radius"),
        of_state("mass", row_of(&S::mass), "mass"),
        of_state("material", row_of(&S::material), "material"),
        of_state("rotation", row_of(&S::rotation), "rotation", "friction or spin", f.turning),
        of_state("cells", row_of(&S::cells), "cells it belongs to", "cells", f.cells),
        of_state("layer", row_of(&S::layer), "layer", "layers", f.layers),
        of_set("a", row_of(&C::a), "first body"),
        of_set("b", row_of(&C::b), "second body"),
        of_set("r_n", row_of(&C::r_n), "normal impulse, across rebuilds"),
        of_set("r_t", row_of(&C::r_t), "tangential impulse, likewise", "friction", f.friction),
        of_set("bond", row_of(&C::bond), "state of the bond", "cohesion", f.cohesion),
        Field{candidate, "asleep", sizeof(std::int32_t), "list of those that can not act", "", true, "DiskContacts"},
        of_lanes("batches", lane_of<DiskBatch>, "normal, bias, 1/W, normal impulse, bodies"),
        of_lanes("source", sizeof(std::int32_t), "candidate of a lane"),
        of_lanes("tangent", lane_of<TangentBatch>, "tangential impulse", "friction", f.friction),
        of_lanes("friction", lane_of<FrictionBatch>, "friction coefficient", "mixed friction", f.mixed_friction),
        Field{grain, "velocities", static_cast<std::size_t>(f.velocities_kept) * sizeof(BodyVelocity<2>),
              "velocities that the method keeps", "method", f.velocities_kept > 0, "Iteration"},
        Field{grain, "quiet", sizeof(BodyVelocity<2>),
              "velocity when its tile became quiet, for each tile that reaches it", "adaptive sweeps", f.adaptive,
              "Iteration"},
        Field{grain, "u_single", sizeof(BodyVelocity<2, float>), "velocity, rounded", "single precision", f.single,
              "Iteration"},
        of_lanes("single", lane_of<SingleBatch>, "the contact, rounded", "single precision", f.single),
        of_lanes("kept_gaps", lane_of<KeptGapBatch>, "gap", "kept geometry", f.kept_gaps),
        of_lanes("springs", lane_of<SpringBatch>, "springs, dashpots, friction", "smooth contacts", f.smooth),
        of_lanes("tangent_after", lane_of<TangentBatch>, "tangential spring that a step ends with",
                 "smooth contacts with friction", f.smooth && f.friction),
        of_lanes("summed", lane_of<SearchBatch>, "impulse of the substeps before, or beside the spring",
                 "kept geometry", f.kept_normals || f.smooth),
        Field{grain, "correction", sizeof(BodyVelocity<2>), "way to move apart, over the step", "position correction",
              f.correction, "Simulation"},
        of_lanes("corrections", lane_of<DiskBatch>, "the problem of moving grains apart", "position correction",
                 f.correction),
        of_lanes("memory[0]", lane_of<SearchBatch>, "impulse that the method keeps", "method", f.impulses_kept > 0),
        of_lanes("memory[1]", lane_of<SearchBatch>, "another", "method", f.impulses_kept > 1),
        of_lanes("cohesion", lane_of<CohesionBatch>, "attraction, gamma h or 0", "cohesion", f.cohesion),
    };
}

namespace {

template <class Wanted>
std::size_t bytes_of(const Features& features, Wanted&& wanted) {
    std::size_t bytes = 0;
    for (const auto& field : fields_of(features)) {
        bytes += field.carried && wanted(field.per) ? field.bytes : 0;
    }
    return bytes;
}

} // namespace

std::size_t bytes_per_grain(const Features& features) {
    return bytes_of(features, [](Field::Per per) { return per == Field::Per::grain; });
}

std::size_t bytes_per_contact(const Features& features) {
    return bytes_of(features, [](Field::Per per) { return per != Field::Per::grain; });
}

std::string kernel_variant(const Features& features) {
    const std::string friction = !features.friction        ? "frictionless"
                                 : features.mixed_friction ? "mixed friction"
                                                           : "one friction";
    return friction + (features.cohesion ? ", cohesive" : "");
}

} // namespace nappe
