#pragma once
// When tiles change hands. Local, and a function of its inputs: given the same numbers, all ranks decide alike.

#include "core/scene.hpp"

namespace nappe {

class BalanceJudge {
public:
    explicit BalanceJudge(const BalanceSettings& settings) : settings_(settings) {}

    /// At a look. Whether a cut is worth asking for: the imbalance (largest over mean load) is above the threshold and,
    /// unless tiles always move, what the best cut known would save pays for a move. Where tiles are too coarse for the
    /// threshold, the last cut's prediction is the best known, for the next `memory` looks.
    /// @param seconds_ahead that a rank of mean load will relax until the next look [s]
    bool wants_cut(double imbalance, double seconds_ahead);

    /// Whether tiles should move to a cut. Pre: wants_cut has just said yes. @param predicted imbalance of that cut
    bool accepts(double predicted);

    /// What a move has cost the slowest rank, over a rebuild without one [s].
    void moved(double seconds);

    double cost() const { return cost_; } ///< of a move, foreseen from the last ones [s]

    static constexpr int memory = 10; ///< looks
    /// Of the mean load: a smaller gain is within the noise of what comes next.
    static constexpr double least_gain = 0.002;

private:
    bool pays(double target) const;

    BalanceSettings settings_;
    double imbalance_ = 1;
    double seconds_ahead_ = 0;
    double best_ = 1; ///< imbalance that the last cut could reach
    int looks_ = 0;   ///< since then
    double cost_ = 0; ///< 0: none yet
};

} // namespace nappe
