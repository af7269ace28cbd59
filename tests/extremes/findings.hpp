#pragma once
// What the extremes share: the short and the long form, and the rows of docs/extremes.md. A test checks what must hold
// and says what it found; tests/extremes/table.py collects the rows into the tables of the page.

#include "core/error.hpp"
#include "support/serial_run.hpp"

#include <fmt/format.h>

#include <cmath>
#include <cstdlib>
#include <string>
#include <vector>

namespace nappe::test {

/// Finer decades, larger stacks and more steps: `tools/test --long`.
inline bool long_form() {
    const char* asked = std::getenv("NAPPE_EXTREMES");
    return asked != nullptr && std::string(asked) == "long";
}

/// A row of the table named `table`; the columns are named where docs/extremes.md shows it.
template <class... Columns>
void found(const char* table, const Columns&... columns) {
    std::string row = fmt::format("found | {} |", table);
    ((row += fmt::format(" {} |", columns)), ...);
    fmt::print("{}\n", row);
}

/// Three digits, as the tables show numbers.
inline std::string digits(double x) {
    return fmt::format("{:.3g}", x);
}

/// `from`, `from` x factor, … up to `to`.
inline std::vector<double> decades(double from, double to, double factor = 10) {
    std::vector<double> values;
    for (double x = from; x < to * (1 + 1e-9); x *= factor) {
        values.push_back(x);
    }
    return values;
}

/// How a run of n steps ended: "" or what the program would say to its user (exit code 4).
template <class Each>
std::string run_or_refusal(SerialRun& run, std::int64_t n, Each&& after_each_step) {
    try {
        for (std::int64_t k = 0; k < n; ++k) {
            run.steps(1);
            after_each_step();
        }
    } catch (const NumericalFailure& refusal) {
        return refusal.what();
    }
    return "";
}

inline std::string run_or_refusal(SerialRun& run, std::int64_t n) {
    return run_or_refusal(run, n, [] {});
}

inline double kinetic(const SerialRun& run) {
    double sum = 0;
    for (LocalId i = 0; i < run.state().n_own; ++i) {
        sum += kinetic_energy(run.state().u[i], run.state().mass[i]);
    }
    return sum;
}

/// Of gravity, 0 at the origin [J].
inline double potential(SerialRun& run) {
    double sum = 0;
    for (LocalId i = 0; i < run.state().n_own; ++i) {
        sum -= run.state().mass[i] * run.simulation().scene().gravity.dot(run.state().x[i]);
    }
    return sum;
}

inline Vec<2> momentum(const SerialRun& run) {
    Vec<2> sum = Vec<2>::Zero();
    for (LocalId i = 0; i < run.state().n_own; ++i) {
        sum += run.state().mass[i] * Vec<2>(run.state().u[i].v[0], run.state().u[i].v[1]);
    }
    return sum;
}

inline bool all_finite(const SerialRun& run) {
    bool finite = true;
    for (LocalId i = 0; i < run.state().n_own; ++i) {
        const auto& u = run.state().u[i];
        finite = finite && std::isfinite(run.state().x[i][0] + run.state().x[i][1] + u.v[0] + u.v[1] + u.s[0]);
    }
    return finite;
}

} // namespace nappe::test
