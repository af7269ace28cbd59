#pragma once
// One table of numbers against time, DIR/series/NAME.csv.

#include "io/atomic_file.hpp"

#include <cstdint>
#include <span>
#include <string>
#include <vector>

namespace nappe {

/// Appends rows to a CSV file with the header "step,time,…". Local, for rank 0 alone: a failure must not throw there
/// between two collectives, so it is kept, and the caller shares error() with the other ranks.
class SeriesWriter {
public:
    /// Replaces an older file. columns: names after step and time, with their unit where they have one ("p [Pa]").
    SeriesWriter(std::filesystem::path path, const std::vector<std::string>& columns);

    /// Goes on with a file that had `bytes` bytes at a checkpoint: what came after goes. Local.
    SeriesWriter(std::filesystem::path path, const std::vector<std::string>& columns, std::int64_t bytes);

    /// Adds one row, at once visible to readers; a row that does not fit on the disk is taken back whole. Numbers have
    /// the fewest digits that read back to the same bits. Does nothing after a failure. values: one per column.
    void append(std::int64_t step, double time, std::span<const double> values);

    /// Waits until all rows are on the disk.
    void sync();
    std::int64_t bytes() const { return size_; } ///< of complete rows

    /// Waits until all rows are on the disk, and closes. More rows can not follow.
    void finish();

    /// What went wrong first, with path and remedy; empty while all is well.
    const std::string& error() const { return error_; }

private:
    void write_line(const std::string& line);
    void fail(std::string_view what, int error_number);

    std::filesystem::path path_;
    std::size_t n_columns_;
    FileDescriptor file_;
    std::int64_t size_ = 0; ///< bytes of complete rows
    std::string error_;
};

} // namespace nappe
