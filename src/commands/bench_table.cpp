#include "commands/bench_table.hpp"

#include "core/error.hpp"

#include <fmt/format.h>

#include <algorithm>

namespace nappe {

void BenchTable::add(Row cells) {
    NAPPE_ASSERT(cells.size() == columns_.size(), key_ + ": a row of " + std::to_string(cells.size()) + " cells");
    rows_.push_back(std::move(cells));
}

std::string BenchTable::shown(const nlohmann::ordered_json& cell, std::size_t column) const {
    if (cell.is_null()) {
        return "-";
    }
    if (cell.is_boolean()) {
        return cell.get<bool>() ? "yes" : "no";
    }
    if (cell.is_string()) {
        return cell.get<std::string>();
    }
    return cell.is_number_integer() ? fmt::format("{}", cell.get<std::int64_t>())
                                    : fmt::format("{:.{}f}", cell.get<double>(), columns_[column].digits);
}

std::string BenchTable::text() const {
    std::string lines = caption_ + "\n";
    std::vector<std::size_t> width;
    for (std::size_t c = 0; c < columns_.size(); ++c) {
        width.push_back(columns_[c].head.size());
        for (const auto& row : rows_) {
            width[c] = std::max(width[c], shown(row[c], c).size());
        }
    }
    const auto put = [&](const std::string& what, std::size_t c, bool left) {
        const std::string gap = c == 0 ? "  " : "   ";
        lines += left ? fmt::format("{}{:<{}}", gap, what, width[c]) : fmt::format("{}{:>{}}", gap, what, width[c]);
    };
    const auto is_text = [&](std::size_t c) { return !rows_.empty() && rows_.front()[c].is_string(); };
    const auto end_line = [&] {
        lines.erase(lines.find_last_not_of(' ') + 1);
        lines += '\n';
    };
    for (std::size_t c = 0; c < columns_.size(); ++c) {
        put(columns_[c].head, c, is_text(c));
    }
    end_line();
    for (const auto& row : rows_) {
        for (std::size_t c = 0; c < columns_.size(); ++c) {
            put(shown(row[c], c), c, is_text(c));
        }
        end_line();
    }
    return lines + "\n";
}

nlohmann::ordered_json BenchTable::json() const {
    auto rows = nlohmann::ordered_json::array();
    for (const auto& row : rows_) {
        nlohmann::ordered_json object;
        for (std::size_t c = 0; c < columns_.size(); ++c) {
            object[columns_[c].key] = row[c];
        }
        rows.push_back(std::move(object));
    }
    return rows;
}

} // namespace nappe
