#pragma once
// The three kinds of error (CONTRIBUTING.md): a bug aborts, the world throws, numerics are reported as values.

#include <stdexcept>
#include <string>

namespace nappe {

/// What the process returns to the shell; batch scripts act on these.
enum class ExitCode : int { done = 0, other = 1, bad_input = 2, stopped_early = 3, numerical_failure = 4 };

/// The user's input breaks a rule. The text holds the rule, the value found and the remedy. Exit code 2.
struct InputError : std::runtime_error {
    using std::runtime_error::runtime_error;
};

/// The computation can not go on (NaN, a grain through a wall, a criterion that is never met). Exit code 4.
struct NumericalFailure : std::runtime_error {
    using std::runtime_error::runtime_error;
};

/// The machine refuses (disk full, folder read-only, a file that changed under us). Exit code 1.
struct SystemError : std::runtime_error {
    using std::runtime_error::runtime_error;
};

[[noreturn]] void assertion_failed(const char* condition, const char* file, int line, const std::string& values);

} // namespace nappe

#ifdef NAPPE_ASSERTIONS
/// A bug if false: prints rank, place and values, then aborts. On in debug and audit builds only.
#define NAPPE_ASSERT(condition, values) \
    ((condition) ? void(0) : ::nappe::assertion_failed(#condition, __FILE__, __LINE__, (values)))
#else
#define NAPPE_ASSERT(condition, values) void(0)
#endif
