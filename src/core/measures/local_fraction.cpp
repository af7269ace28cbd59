#include "core/measures/local_fraction.hpp"

#include "core/measures/coarse_grain.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <utility>

namespace nappe {

namespace {

/// Squares of side w that hold grains; the grains of one are in their order.
class Squares {
public:
    Squares(std::span<const FieldGrain> grains, double side) : side_(side) {
        entries_.reserve(grains.size());
        for (std::size_t i = 0; i < grains.size(); ++i) {
            entries_.push_back({square(grains[i].x), square(grains[i].y), i});
        }
        std::sort(entries_.begin(), entries_.end());
    }

    /// Appends the grains of a column of three squares around (column, square of y), in order of squares.
    void append(std::int64_t column, double y, std::vector<std::size_t>& grains) const {
        const std::int64_t row = square(y);
        for (auto e = std::lower_bound(entries_.begin(), entries_.end(), Entry{column, row - 1, 0});
             e != entries_.end() && e->column == column && e->row <= row + 1; ++e) {
            grains.push_back(e->grain);
        }
    }

    std::int64_t square(double x) const { return static_cast<std::int64_t>(std::floor(x / side_)); }

private:
    struct Entry {
        std::int64_t column, row;
        std::size_t grain;
        auto operator<=>(const Entry&) const = default;
    };
    double side_;
    std::vector<Entry> entries_;
};

} // namespace

std::vector<double> local_solid_fractions(std::span<const FieldGrain> grains, double range) {
    const Squares squares(grains, range);
    std::vector<double> fractions;
    std::vector<std::size_t> near;
    for (const auto& target : grains) {
        if (!target.is_target) {
            continue;
        }
        near.clear();
        const std::int64_t column = squares.square(target.x);
        for (const std::int64_t k : {column - 1, column, column + 1}) {
            squares.append(k, target.y, near);
        }
        std::sort(near.begin(), near.end());
        double sum = 0;
        for (const std::size_t j : near) {
            const double dx = grains[j].x - target.x, dy = grains[j].y - target.y;
            const double s = std::sqrt(dx * dx + dy * dy) / range;
            if (s < 1) {
                sum += std::numbers::pi * grains[j].radius * grains[j].radius * lucy(s, range);
            }
        }
        fractions.push_back(sum);
    }
    return fractions;
}

} // namespace nappe
