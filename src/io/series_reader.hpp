#pragma once
// Reads back the tables that io/series.hpp writes. Local.

#include <filesystem>
#include <string_view>
#include <vector>

namespace nappe {

/// The columns of a CSV file, rows in the order of the file.
class SeriesTable {
public:
    std::size_t n_rows() const { return values_.empty() ? 0 : values_.front().size(); }
    bool has(std::string_view column) const { return index(column) < names_.size(); }
    /// Throws InputError if there is no such column.
    const std::vector<double>& operator[](std::string_view column) const;

private:
    friend SeriesTable read_series(const std::filesystem::path& path);
    std::size_t index(std::string_view column) const;

    std::filesystem::path path_;
    std::vector<std::string> names_;
    std::vector<std::vector<double>> values_; ///< by column
};

/// Throws InputError if the file is not there or not such a table; nan is a number here.
SeriesTable read_series(const std::filesystem::path& path);

} // namespace nappe
