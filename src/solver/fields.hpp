#pragma once
// The one list of what is stored for every grain and contact of a scene, and for the sake of what: `nappe check` prints
// it, `nappe run` sums it, and a test compares it with the arrays of running scenes.

#include "core/features.hpp"

#include <cstddef>
#include <string>
#include <vector>

namespace nappe {

/// One array that a step works on.
struct Field {
    enum class Per { grain, candidate, packed }; ///< packed: a lane of a batch
    Per per = Per::grain;
    std::string name;            ///< as for_each_array has it
    std::size_t bytes = 0;       ///< of one row
    std::string holds;           ///< what, in words
    std::string asked_by;        ///< the feature; empty: every scene needs it
    bool carried = true;         ///< in loading stages
    const char* where = "State"; ///< the type that has it
};

/// Local. All fields there are, for disks in the plane.
std::vector<Field> fields_of(const Features& features);

/// Bytes of the arrays over grains that a scene carries.
std::size_t bytes_per_grain(const Features& features);

/// Bytes of the arrays over candidates and lanes that a scene carries, for a contact that has both.
std::size_t bytes_per_contact(const Features& features);

/// Which variant of the sweep's kernel relaxes the contacts of a scene while it is loaded: "frictionless",
/// "mixed friction, cohesive", …
std::string kernel_variant(const Features& features);

} // namespace nappe
