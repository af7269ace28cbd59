#include "io/series.hpp"

#include <fmt/format.h>

#include <cerrno>
#include <fcntl.h>
#include <iterator>
#include <unistd.h>

namespace nappe {

namespace {

/// Quoted where a comma, a quote or a line end would break the row (RFC 4180).
std::string csv_field(const std::string& text) {
    if (text.find_first_of(",\"\r\n") == std::string::npos) {
        return text;
    }
    std::string quoted = "\"";
    for (const char c : text) {
        quoted += c == '"' ? std::string("\"\"") : std::string(1, c);
    }
    return quoted + '"';
}

std::string header_of(const std::vector<std::string>& columns) {
    std::string header = "step,time";
    for (const auto& column : columns) {
        header += ',' + csv_field(column);
    }
    return header + '\n';
}

} // namespace

SeriesWriter::SeriesWriter(std::filesystem::path path, const std::vector<std::string>& columns)
    : path_(std::move(path)), n_columns_(columns.size()) {
    try {
        file_ = FileDescriptor(path_, O_WRONLY | O_CREAT | O_TRUNC);
    } catch (const std::exception& failure) {
        error_ = failure.what();
    }
    write_line(header_of(columns));
}

SeriesWriter::SeriesWriter(std::filesystem::path path, const std::vector<std::string>& columns, std::int64_t bytes)
    : path_(std::move(path)), n_columns_(columns.size()) {
    try {
        file_ = FileDescriptor(path_, O_RDWR | O_APPEND);
        const auto header = header_of(columns);
        std::string found(header.size(), '\0');
        if (::pread(file_.get(), found.data(), found.size(), 0) != static_cast<ssize_t>(found.size()) ||
            found != header) {
            error_ = fmt::format("{}: must begin with the columns of this scene, found others; put the series of this "
                                 "run back, or run the scene anew in another folder",
                                 path_.string());
            return;
        }
        const auto size = static_cast<std::int64_t>(std::filesystem::file_size(path_));
        if (size < bytes) {
            error_ =
                fmt::format("{}: must hold the {} bytes it had at the checkpoint, found {}: rows are lost; put the "
                            "file back, or run the scene anew in another folder",
                            path_.string(), bytes, size);
            return;
        }
        if (::ftruncate(file_.get(), bytes) != 0) {
            fail("rows after the checkpoint can not be taken away", errno);
        }
        size_ = bytes;
    } catch (const std::exception& failure) {
        error_ = failure.what();
    }
}

void SeriesWriter::append(std::int64_t step, double time, std::span<const double> values) {
    if (values.size() != n_columns_ && error_.empty()) {
        error_ = fmt::format("{}: {} values for {} columns: a bug of nappe", path_.string(), values.size(), n_columns_);
    }
    std::string line;
    fmt::format_to(std::back_inserter(line), "{},{}", step, time);
    for (const double value : values) {
        fmt::format_to(std::back_inserter(line), ",{}", value);
    }
    write_line(line + '\n');
}

void SeriesWriter::sync() {
    if (error_.empty() && file_ && ::fsync(file_.get()) != 0) {
        fail("writing to the disk fails", errno);
    }
}

void SeriesWriter::finish() {
    sync();
    if (const int failure = file_.close(); failure && error_.empty()) {
        fail("closing fails", failure);
    }
}

void SeriesWriter::write_line(const std::string& line) {
    if (!error_.empty()) {
        return;
    }
    if (const int failure = write_all(file_, line)) {
        fail("a row can not be written", failure);
        // Half a row at the end would be read as a number of its own.
        [[maybe_unused]] const int ignored = ::ftruncate(file_.get(), size_);
        return;
    }
    size_ += static_cast<std::int64_t>(line.size());
}

void SeriesWriter::fail(std::string_view what, int error_number) {
    error_ = fmt::format("{}: {}: {}", path_.string(), what, remedy_for_writing(error_number));
}

} // namespace nappe
