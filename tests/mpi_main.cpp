// main() of tests that run on several ranks: every rank runs every test; only rank 0 prints, unless a test fails
// elsewhere.
#include "parallel/communicator.hpp"

#include <gtest/gtest.h>

int main(int argc, char** argv) {
    nappe::MpiSession mpi(argc, argv);
    nappe::Communicator world(MPI_COMM_WORLD);
    testing::InitGoogleTest(&argc, argv);
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
