#include "io/series_reader.hpp"

#include "core/error.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <charconv>
#include <fstream>
#include <string>

namespace nappe {

namespace {

std::vector<std::string> fields(const std::string& line) {
    std::vector<std::string> parts(1);
    for (const char c : line) {
        if (c == ',') {
            parts.emplace_back();
        } else if (c != '\r') {
            parts.back() += c;
        }
    }
    return parts;
}

} // namespace

std::size_t SeriesTable::index(std::string_view column) const {
    return static_cast<std::size_t>(std::find(names_.begin(), names_.end(), column) - names_.begin());
}

const std::vector<double>& SeriesTable::operator[](std::string_view column) const {
    if (!has(column)) {
        throw InputError(fmt::format("{}: must have a column {}, found none; was it changed, or written by another "
                                     "version of nappe? Delete its run to have it made again",
                                     path_.string(), column));
    }
    return values_[index(column)];
}

SeriesTable read_series(const std::filesystem::path& path) {
    SeriesTable table;
    table.path_ = path;
    std::ifstream file(path);
    std::string line;
    if (!std::getline(file, line)) {
        throw InputError(fmt::format("{}: must be a series with a header line, found none; delete its run to have it "
                                     "made again",
                                     path.string()));
    }
    table.names_ = fields(line);
    table.values_.resize(table.names_.size());
    for (int number = 2; std::getline(file, line); ++number) {
        const auto row = fields(line);
        bool good = row.size() == table.names_.size();
        for (std::size_t c = 0; good && c < row.size(); ++c) {
            double value = 0;
            const auto* end = row[c].data() + row[c].size();
            const auto [stop, error] = std::from_chars(row[c].data(), end, value);
            good = error == std::errc() && stop == end;
            table.values_[c].push_back(value);
        }
        if (!good) {
            throw InputError(fmt::format("{}:{}: must be {} numbers with commas between them, found \"{}\"; delete its "
                                         "run to have it made again",
                                         path.string(), number, table.names_.size(), line));
        }
    }
    return table;
}

} // namespace nappe
