#pragma once
// The value of a figure where there is nothing to tell it by.

#include <limits>

namespace nappe {

inline constexpr double no_value = std::numeric_limits<double>::quiet_NaN();

} // namespace nappe
