#pragma once
// Which runs a matrix of settings means for a scene, and which of them are done.

#include "commands/trade_figures.hpp"
#include "core/scene.hpp"
#include "io/trade_matrix.hpp"

#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

namespace nappe {

/// One setting with one seed.
struct PlannedRun {
    std::size_t setting = 0; ///< 0: the reference, k: TradeMatrix::settings[k - 1]
    std::size_t seed = 0;    ///< index into TradePlan::seeds
    Scene<2> scene;
    std::int64_t steps = 0; ///< of loading
    std::filesystem::path folder;
};

struct TradePlan {
    std::vector<std::string> names;  ///< by setting
    std::vector<std::int64_t> seeds; ///< {0} for a scene without a sample: it has none
    std::vector<PlannedRun> runs;    ///< seed by seed, the reference first, so that a part of it can be judged
};

/// The runs below folder/runs/NAME/seed-S. Every scene starts from the state that the reference starts from, with the
/// same seed. Local. Throws InputError: whatever is wrong with the scene alone, then with its settings, a line each.
/// @param text of the scene file @param overrides KEY=VALUE, for all runs
TradePlan plan_trade(std::string_view text, const std::string& file_name, const std::vector<std::string>& overrides,
                     const TradeMatrix& matrix, const std::filesystem::path& folder);

enum class RunState : char { to_do = '-', done = 'd', failed = 'f' };

/// What the folder of a run holds. Local. Throws InputError if that is a finished run of another scene, or of another
/// length: it would be lost, or pass for this one.
RunState state_of(const PlannedRun& run);

/// Keeps for the next time why a run failed, beside what it left. Local. Throws SystemError.
void remember_failure(const PlannedRun& run, const std::string& reason);

/// The reason kept; "" if there is none. Local.
std::string failure_of(const PlannedRun& run);

} // namespace nappe
