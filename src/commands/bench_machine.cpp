#include "commands/bench_machine.hpp"

#include "commands/bench_loops.hpp"
#include "io/summary.hpp"
#include "parallel/communicator.hpp"

#include <fmt/format.h>

#include <fstream>
#include <iterator>
#include <thread>

namespace nappe {

namespace {

std::string text_of(const std::string& path) {
    std::ifstream file(path);
    std::string text(std::istreambuf_iterator<char>(file), {});
    text.erase(text.find_last_not_of(" \n") + 1);
    return text;
}

/// "L1 Data 48K, L2 Unified 2048K …" of the first core; "unknown" where the system does not say.
std::string caches() {
    std::string list;
    for (int k = 0;; ++k) {
        const auto folder = fmt::format("/sys/devices/system/cpu/cpu0/cache/index{}/", k);
        const auto size = text_of(folder + "size");
        if (size.empty()) {
            return list.empty() ? "unknown" : list;
        }
        list += fmt::format("{}L{} {} {}", list.empty() ? "" : ", ", text_of(folder + "level"),
                            text_of(folder + "type"), size);
    }
}

std::string or_unknown(const std::string& text) {
    return text.empty() ? "unknown" : text;
}

} // namespace

std::string processor_model(std::string_view cpuinfo) {
    constexpr std::string_view key = "model name";
    const auto line = cpuinfo.find(key);
    if (line == std::string_view::npos) {
        return {};
    }
    const auto from = cpuinfo.find(": ", line);
    const auto to = cpuinfo.find('\n', line);
    return from < to ? std::string(cpuinfo.substr(from + 2, to - from - 2)) : std::string();
}

nlohmann::ordered_json describe_machine(int ranks, const std::vector<std::string>& kernels) {
    nlohmann::ordered_json machine;
    machine["processor"] = or_unknown(processor_model(text_of("/proc/cpuinfo")));
    machine["cores"] = std::thread::hardware_concurrency();
    machine["caches"] = caches();
    machine["huge_pages"] = or_unknown(text_of("/sys/kernel/mm/transparent_hugepage/enabled"));
    machine["ranks"] = ranks;
    machine["mpi"] = mpi_library();
    machine["version"] = program_version();
    machine["compiler"] = NAPPE_COMPILER;
    machine["flags"] = NAPPE_FLAGS;
    machine["flags_portable"] = NAPPE_FLAGS_PORTABLE;
#ifdef NAPPE_X86
    machine["flags_avx2"] = NAPPE_FLAGS_AVX2;
    machine["flags_avx512"] = NAPPE_FLAGS_AVX512;
#endif
    machine["kernels"] = fmt::format("{}", fmt::join(kernels, ", "));
    machine["reference_and_triad"] = fmt::format("compiled with the flags of {}", bench_loops().name);
    return machine;
}

} // namespace nappe
