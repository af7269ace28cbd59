#pragma once
// What figures were measured on: processor, caches, compiler, flags, MPI library. Local, of this rank's machine.

#include <nlohmann/json.hpp>

#include <string>
#include <string_view>
#include <vector>

namespace nappe {

/// In the order shown; texts, but for whole numbers.
nlohmann::ordered_json describe_machine(int ranks, const std::vector<std::string>& kernels);

/// "Model name" of the first processor in the text of /proc/cpuinfo; empty if it has none.
std::string processor_model(std::string_view cpuinfo);

} // namespace nappe
