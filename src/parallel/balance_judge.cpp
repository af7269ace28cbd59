#include "parallel/balance_judge.hpp"

namespace nappe {

bool BalanceJudge::wants_cut(double imbalance, double seconds_ahead) {
    imbalance_ = imbalance;
    seconds_ahead_ = seconds_ahead;
    if (++looks_ > memory) {
        best_ = 1;
    }
    return imbalance > settings_.threshold && (settings_.moves == BalanceSettings::Moves::always || pays(best_));
}

bool BalanceJudge::accepts(double predicted) {
    best_ = predicted;
    looks_ = 0;
    return settings_.moves == BalanceSettings::Moves::always || pays(predicted);
}

void BalanceJudge::moved(double seconds) {
    const double now = seconds > 0 ? seconds : 0;
    cost_ = cost_ > 0 ? 0.5 * (cost_ + now) : now;
}

/// A step waits for its slowest rank, so evening the load saves the mean rank's time times the drop of the imbalance.
bool BalanceJudge::pays(double target) const {
    const double gain = imbalance_ - target;
    return gain >= least_gain && gain * seconds_ahead_ > cost_;
}

} // namespace nappe
