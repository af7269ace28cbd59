#include "core/deposit_sites.hpp"

#include "core/random.hpp"

#include <algorithm>
#include <cmath>

namespace nappe {

SiteHeaps::SiteHeaps(double r_min, double r_max, std::uint64_t seed) : r_min_(r_min), r_max_(r_max), seed_(seed) {
    // A class a fiftieth of r_max wide orders heights to about a hundredth of r_max, far below the scatter of heights.
    const double width = r_max / 50;
    const int n = std::clamp(static_cast<int>(std::ceil((r_max - r_min) / width)), 1, 50);
    for (int c = 0; c < n; ++c) {
        classes_.push_back({r_min + (r_max - r_min) * c / n, r_min + (r_max - r_min) * (c + 1) / n, {}});
    }
}

void SiteHeaps::offer(const Packing& packing, const Site& site) {
    // Most pairs have a third disk between or above them and hold none at all.
    if (packing.try_site(site, r_min_).fit == Fit::too_large || packing.try_site(site, r_max_).fit == Fit::too_small) {
        return;
    }
    const auto pair =
        static_cast<std::uint64_t>(static_cast<std::uint32_t>(site.a)) << 32 | static_cast<std::uint32_t>(site.b);
    const double raised = r_max_ / 2 * random_uniform(seed_, RandomStream::deposit_order, pair);
    for (auto& size_class : classes_) {
        Trial trial = packing.try_site(site, (size_class.r_low + size_class.r_high) / 2);
        if (trial.fit != Fit::fits) {
            trial = packing.try_site(site, trial.fit == Fit::too_large ? size_class.r_low : size_class.r_high);
        }
        if (trial.fit == Fit::fits) {
            size_class.sites.push({trial.centre[1] + raised, site});
        } else if (trial.fit == Fit::too_large) {
            return;
        }
    }
}

std::optional<Vec<2>> SiteHeaps::lowest(const Packing& packing, double radius) {
    SizeClass& own = class_of(radius);
    std::optional<Vec<2>> found;
    set_aside_.clear();
    while (!found && !own.sites.empty()) {
        const Entry entry = own.sites.top();
        own.sites.pop();
        const Trial trial = packing.try_site(entry.site, radius);
        if (trial.fit == Fit::fits) {
            found = trial.centre;
            continue;
        }
        const double best_of_class = trial.fit == Fit::too_large ? own.r_low : own.r_high;
        if (packing.try_site(entry.site, best_of_class).fit == Fit::fits) {
            set_aside_.push_back(entry);
        }
    }
    for (const Entry& entry : set_aside_) {
        own.sites.push(entry);
    }
    return found;
}

bool SiteHeaps::empty() const {
    return std::all_of(classes_.begin(), classes_.end(),
                       [](const auto& size_class) { return size_class.sites.empty(); });
}

bool SiteHeaps::Entry::operator>(const Entry& other) const {
    if (height != other.height) {
        return height > other.height;
    }
    return site.a != other.site.a ? site.a > other.site.a : site.b > other.site.b;
}

SiteHeaps::SizeClass& SiteHeaps::class_of(double radius) {
    if (classes_.size() == 1) {
        return classes_.front();
    }
    const auto n = static_cast<int>(classes_.size());
    auto c = std::clamp(static_cast<int>((radius - r_min_) / (r_max_ - r_min_) * n), 0, n - 1);
    while (c > 0 && radius < classes_[c].r_low) {
        --c;
    }
    return classes_[c];
}

} // namespace nappe
