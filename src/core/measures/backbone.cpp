#include "core/measures/backbone.hpp"

#include <numeric>

namespace nappe {

template <int D>
Backbone::Backbone(GlobalId first, std::size_t n, std::span<const ContactSide<D>> sides)
    : first_(first), begin_(n + 1, 0), count_(n, 0), taken_(n, false), doubtful_(n) {
    for (const auto& side : sides) {
        if (side.carries) {
            ++count_[static_cast<std::size_t>(side.grain - first)];
            partners_.push_back(side.partner);
        }
    }
    std::partial_sum(count_.begin(), count_.end(), begin_.begin() + 1);
    std::iota(doubtful_.begin(), doubtful_.end(), std::size_t{0});
}

std::vector<GlobalId> Backbone::take_rattlers() {
    std::vector<GlobalId> elsewhere;
    while (!doubtful_.empty()) {
        const std::size_t row = doubtful_.back();
        doubtful_.pop_back();
        if (taken_[row] || count_[row] >= 2) {
            continue;
        }
        taken_[row] = true;
        for (auto k = begin_[row]; k < begin_[row + 1]; ++k) {
            const GlobalId partner = partners_[k];
            if (partner >= first_ && partner < first_ + static_cast<GlobalId>(taken_.size())) {
                lose_contact(partner);
            } else if (partner < wall_key) {
                elsewhere.push_back(partner);
            }
        }
    }
    return elsewhere;
}

void Backbone::lose_contact(GlobalId grain) {
    const auto row = static_cast<std::size_t>(grain - first_);
    --count_[row];
    doubtful_.push_back(row);
}

template Backbone::Backbone(GlobalId, std::size_t, std::span<const ContactSide<2>>);

} // namespace nappe
