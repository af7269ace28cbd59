#pragma once
// Numbers that survive JSON bit for bit, those that JSON does not know too. Local.

#include <nlohmann/json.hpp>

#include <cmath>
#include <cstdlib>
#include <span>
#include <string>
#include <vector>

namespace nappe {

/// A number, which JSON writes in the digits that read back to the same bits; NaN and infinities as a text.
inline nlohmann::ordered_json exact(double value) {
    if (std::isfinite(value)) {
        return value;
    }
    return std::isnan(value) ? "nan" : value > 0 ? "inf" : "-inf";
}

/// Back. Throws nlohmann's exceptions.
inline double from_exact(const nlohmann::ordered_json& json) {
    return json.is_string() ? std::strtod(json.get_ref<const std::string&>().c_str(), nullptr) : json.get<double>();
}

} // namespace nappe
