#pragma once
// One table of figures, as text for people and as JSON for programs: an array of objects, one a row.

#include <nlohmann/json.hpp>

#include <string>
#include <vector>

namespace nappe {

class BenchTable {
public:
    struct Column {
        std::string key;  ///< in JSON; names the unit
        std::string head; ///< in the text
        int digits = 0;   ///< of numbers that are not whole, after the point
    };
    using Row = std::vector<nlohmann::ordered_json>;

    /// @param caption what the figures mean and how they were counted
    BenchTable(std::string key, std::string caption, std::vector<Column> columns)
        : key_(std::move(key)), caption_(std::move(caption)), columns_(std::move(columns)) {}

    /// A cell a column: text, whole number, number, bool, or null for what does not exist.
    void add(Row cells);

    /// Caption, heads, rows; numbers to the right, text to the left; ends with an empty line.
    std::string text() const;

    nlohmann::ordered_json json() const;
    const std::string& key() const { return key_; }
    bool empty() const { return rows_.empty(); }

private:
    std::string shown(const nlohmann::ordered_json& cell, std::size_t column) const;

    std::string key_, caption_;
    std::vector<Column> columns_;
    std::vector<Row> rows_;
};

} // namespace nappe
