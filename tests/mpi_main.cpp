// main() of tests that run on several ranks: every rank runs every test of the sources that are named as arguments, or all
// tests; only rank 0 prints, unless a test fails elsewhere.
#include "parallel/communicator.hpp"

#include <gtest/gtest.h>

#include <cstdio>
#include <filesystem>
#include <string>

namespace {

/// Adds the tests of a source to those that run; false if it has none.
bool choose(const std::filesystem::path& source) {
    const auto& all = *testing::UnitTest::GetInstance();
    bool found = false;
    for (int k = 0; k < all.total_test_suite_count(); ++k) {
        const auto& suite = *all.GetTestSuite(k);
        for (int m = 0; m < suite.total_test_count(); ++m) {
            const auto& test = *suite.GetTestInfo(m);
            if (std::filesystem::path(test.file()).filename() == source.filename()) {
                GTEST_FLAG_SET(filter, GTEST_FLAG_GET(filter) + ":" + suite.name() + "." + test.name());
                found = true;
            }
        }
    }
    return found;
}

} // namespace

int main(int argc, char** argv) {
    nappe::MpiSession mpi(argc, argv);
    nappe::Communicator world(MPI_COMM_WORLD);
    testing::InitGoogleTest(&argc, argv);
    if (argc > 1) {
        GTEST_FLAG_SET(filter, "");
    }
    for (int k = 1; k < argc; ++k) {
        if (!choose(argv[k])) {
            std::fprintf(stderr, "no test here is from %s\n", argv[k]);
            return 1;
        }
    }
    if (!world.is_root()) {
        auto& listeners = testing::UnitTest::GetInstance()->listeners();
        delete listeners.Release(listeners.default_result_printer());
        class FailuresOnly : public testing::EmptyTestEventListener {
            void OnTestPartResult(const testing::TestPartResult& result) override {
                if (result.failed()) {
                    std::fprintf(stderr, "%s:%d: %s\n", result.file_name(), result.line_number(), result.message());
                }
            }
        };
        listeners.Append(new FailuresOnly);
    }
    const int mine = RUN_ALL_TESTS();
    return static_cast<int>(world.max(static_cast<std::int64_t>(mine)));
}
