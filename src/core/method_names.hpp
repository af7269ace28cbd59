#pragma once
// What solver methods are called in scenes and messages.

#include "core/scene.hpp"

#include <initializer_list>
#include <utility>

namespace nappe {

inline constexpr std::initializer_list<std::pair<const char*, SolverSettings::Method>> method_names = {
    {"nsgs", SolverSettings::Method::nsgs}, {"ansgs", SolverSettings::Method::ansgs},
    {"nncg", SolverSettings::Method::nncg}, {"apgd", SolverSettings::Method::apgd},
    {"cpg", SolverSettings::Method::cpg},   {"cundall", SolverSettings::Method::cundall},
};

inline const char* method_name(SolverSettings::Method method) {
    for (const auto& [name, value] : method_names) {
        if (value == method) {
            return name;
        }
    }
    return "";
}

} // namespace nappe
