#include "io/summary.hpp"

#include "io/atomic_file.hpp"

#include <fmt/format.h>

namespace nappe {

std::string_view program_version() {
    return NAPPE_VERSION;
}

std::string hex_digits(std::uint64_t value) {
    return fmt::format("{:016x}", value);
}

std::string format_summary(const nlohmann::ordered_json& summary) {
    return summary.dump(2, ' ', false, nlohmann::ordered_json::error_handler_t::replace) + "\n";
}

void write_summary(const std::filesystem::path& path, const nlohmann::ordered_json& summary) {
    write_file_atomically(path, format_summary(summary));
}

} // namespace nappe
