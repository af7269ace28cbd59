// Small files of rank 0: atomic texts, series, summary, checksums.
#include "core/error.hpp"
#include "io/atomic_file.hpp"
#include "io/checksum.hpp"
#include "io/folder_lock.hpp"
#include "io/series.hpp"
#include "io/summary.hpp"
#include "unit/temporary_folder.hpp"

#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <limits>
#include <numbers>
#include <sys/wait.h>
#include <unistd.h>

namespace nappe {
namespace {

using test::FileSizeLimit;
using test::TemporaryFolder;
using test::text_of;

TEST(AtomicFile, ReplacesAnOlderFile) {
    const TemporaryFolder folder;
    const auto path = folder.path() / "run.xdmf";
    write_file_atomically(path, "old");
    write_file_atomically(path, "new, and longer");
    EXPECT_EQ(text_of(path), "new, and longer");
    EXPECT_EQ(folder.n_files(), 1u);
}

TEST(AtomicFile, FullDiskLeavesTheOlderFileAndNoOther) {
    const TemporaryFolder folder;
    const auto path = folder.path() / "run.xdmf";
    write_file_atomically(path, "old");
    {
        const FileSizeLimit limit(100);
        try {
            write_file_atomically(path, std::string(1000, 'x'));
            ADD_FAILURE() << "written beyond the limit";
        } catch (const SystemError& error) {
            const std::string text = error.what();
            EXPECT_NE(text.find("run.xdmf"), std::string::npos) << text;
            EXPECT_NE(text.find("ulimit -f"), std::string::npos) << text;
        }
    }
    EXPECT_EQ(text_of(path), "old");
    EXPECT_EQ(folder.n_files(), 1u);
}

TEST(AtomicFile, MissingFolderIsNamedWithTheRemedy) {
    const TemporaryFolder folder;
    try {
        write_file_atomically(folder.path() / "missing" / "summary.json", "{}");
        ADD_FAILURE() << "written into a folder that is not there";
    } catch (const SystemError& error) {
        const std::string text = error.what();
        EXPECT_NE(text.find("missing/summary.json"), std::string::npos) << text;
        EXPECT_NE(text.find("create the folder first"), std::string::npos) << text;
    }
}

TEST(Series, RowsReadBackToTheSameBits) {
    const TemporaryFolder folder;
    const auto path = folder.path() / "W1.csv";
    const std::array values{0.1 + 0.2, -std::numbers::pi * 1e-300};
    SeriesWriter series(path, {"p [Pa]", "a,b"});
    series.append(10, 0.25, values);
    EXPECT_EQ(text_of(path), "step,time,p [Pa],\"a,b\"\n10,0.25,0.30000000000000004,-3.141592653589793e-300\n")
        << "a row must be in the file as soon as it is appended";
    series.append(20, 0.5, std::array{1.0, std::nan("")});
    series.finish();
    EXPECT_EQ(series.error(), "");
    EXPECT_NE(text_of(path).find("\n20,0.5,1,nan\n"), std::string::npos);
}

TEST(Series, FullDiskIsReportedAndLeavesWholeRows) {
    const TemporaryFolder folder;
    const auto path = folder.path() / "W1.csv";
    SeriesWriter series(path, {"p [Pa]"});
    std::string last_good;
    {
        const FileSizeLimit limit(200);
        for (int step = 0; step < 100 && series.error().empty(); ++step) {
            last_good = text_of(path);
            series.append(step, 0.025 * step, std::array{1.0 / 3});
        }
    }
    EXPECT_NE(series.error().find("W1.csv"), std::string::npos) << series.error();
    EXPECT_NE(series.error().find("ulimit -f"), std::string::npos) << series.error();
    EXPECT_GT(last_good.size(), 100u);
    EXPECT_EQ(text_of(path), last_good);
    const auto first_error = series.error();
    series.append(100, 1, std::array{1.0}); // there is room again, but a row is missing
    series.finish();
    EXPECT_EQ(series.error(), first_error);
    EXPECT_EQ(text_of(path), last_good);
}

TEST(Series, FileThatCanNotBeMadeIsReportedNotThrown) {
    const TemporaryFolder folder;
    SeriesWriter series(folder.path() / "missing" / "W1.csv", {});
    EXPECT_NE(series.error().find("missing/W1.csv"), std::string::npos) << series.error();
}

TEST(Series, WrongNumberOfValuesIsReported) {
    const TemporaryFolder folder;
    SeriesWriter series(folder.path() / "W1.csv", {"p [Pa]", "q [Pa]"});
    series.append(1, 1, std::array{1.0});
    EXPECT_NE(series.error().find("1 values for 2 columns"), std::string::npos) << series.error();
}

TEST(Summary, KeepsOrderBitsAndText) {
    const TemporaryFolder folder;
    nlohmann::ordered_json summary;
    summary["zebra"] = 0.1 + 0.2;
    summary["ant"] = hex_digits(0xabc);
    summary["nothing"] = std::nan("");
    summary["bytes"] = "\xff";
    write_summary(folder.path() / "summary.json", summary);
    EXPECT_EQ(text_of(folder.path() / "summary.json"), "{\n"
                                                       "  \"zebra\": 0.30000000000000004,\n"
                                                       "  \"ant\": \"0000000000000abc\",\n"
                                                       "  \"nothing\": null,\n"
                                                       "  \"bytes\": \"\xef\xbf\xbd\"\n"
                                                       "}\n");
}

TEST(Checksum, OfATableDoesNotDependOnItsDivision) {
    const std::array<std::int64_t, 6> rows{5, 4, 3, 2, 1, 0};
    const auto bytes = std::as_bytes(std::span(rows));
    const auto whole = row_checksum(bytes, 8, 0);
    EXPECT_EQ(row_checksum(bytes.first(16), 8, 0) + row_checksum(bytes.subspan(16), 8, 2), whole);
    std::array<std::int64_t, 6> swapped = rows;
    std::swap(swapped[0], swapped[5]);
    EXPECT_NE(row_checksum(std::as_bytes(std::span(swapped)), 8, 0), whole) << "the order of rows must count";
}

TEST(Remains, OfDeadProcessesGoWhereOthersMayBeWriting) {
    const test::TemporaryFolder folder;
    const auto dead = ::fork();
    if (dead == 0) {
        ::_exit(0);
    }
    ASSERT_EQ(::waitpid(dead, nullptr, 0), dead);
    const auto mine = temporary_name("mine.hdf").string(); // NAME.part-HOST-PROCESS
    const auto host = mine.substr(0, mine.rfind('-'));
    const auto of = [&](pid_t process) { return host + "-" + std::to_string(process); };
    const std::vector<std::string> all{mine, of(dead), of(dead) + ".data.0", "other.hdf.part-elsewhere-1", "whole.hdf"};
    for (const auto& name : all) {
        std::ofstream(folder.path() / name) << "half";
    }
    const auto left = [&] {
        std::vector<std::string> names;
        for (const auto& name : all) {
            if (std::filesystem::exists(folder.path() / name)) {
                names.push_back(name);
            }
        }
        return names;
    };
    remove_remains(folder.path(), true);
    EXPECT_EQ(left(), (std::vector<std::string>{mine, "other.hdf.part-elsewhere-1", "whole.hdf"}));
    remove_remains(folder.path(), false);
    EXPECT_EQ(left(), std::vector<std::string>{"whole.hdf"});
}

} // namespace
} // namespace nappe
