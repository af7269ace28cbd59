#pragma once
// What gauges along walls feel: impulses of the grains on equal bins of a wall, summed over the steps of each gauge's own
// interval. By tile in the order of candidates, then exactly, so that the figures do not depend on ranks.

#include "core/exact_sum.hpp"
#include "core/state.hpp"
#include "core/walls.hpp"

#include <vector>

namespace nappe {

/// Of the grains on a bin [N s].
struct GaugeImpulse {
    double normal = 0;     ///< pressing on the wall, from either side
    double tangential = 0; ///< along the wall, from its first point to its last
};

template <int D>
class GaugeSums {
public:
    GaugeSums(const std::vector<Gauge>& gauges, const Walls<D>& walls) : gauges_(gauges), walls_(&walls) {
        place_features();
        of_wall_.resize(static_cast<std::size_t>(walls.n_walls()));
        for (std::size_t k = 0; k < gauges.size(); ++k) {
            first_.push_back(sums_.size() / 2);
            sums_.resize(sums_.size() + 2 * static_cast<std::size_t>(gauges[k].bins));
            of_wall_[static_cast<std::size_t>(gauges[k].wall)].push_back(k);
        }
        tile_.assign(sums_.size(), 0.0);
        touched_.assign(sums_.size() / 2, false);
    }

    /// Local. A contact of the current tile between a grain at x and the body `sided` of a wall: impulse r on the grain along
    /// unit normal n from the wall to it [N s].
    void add(int sided, const Vec<D>& x, const Vec<D>& n, const Vec<D>& r) {
        static_assert(D == 2, "walls are lines");
        const auto& feature = walls_->feature(sided);
        const auto w = static_cast<std::size_t>(feature.wall);
        if (of_wall_[w].empty()) {
            return;
        }
        const Place& place = places_[static_cast<std::size_t>(sided / 2)];
        double at = place.from;
        if (!feature.is_point) {
            const Vec<D> reach = x - walls_->offset[w] - feature.p;
            const double along = reach[0] * place.tangent[0] + reach[1] * place.tangent[1];
            at += along > feature.length ? feature.length : along > 0 ? along : 0.0;
        }
        const Vec<D> left(-place.tangent[1], place.tangent[0]);
        const double side = n[0] * left[0] + n[1] * left[1] < 0 ? -1.0 : 1.0;
        const double normal = side * (r[0] * left[0] + r[1] * left[1]);
        const double tangential = -(r[0] * place.tangent[0] + r[1] * place.tangent[1]);
        for (const std::size_t k : of_wall_[w]) {
            const Gauge& gauge = gauges_[k];
            // The wall's own end belongs to what reaches it: lengths are sums, and rounded.
            if (at < gauge.from || (at > gauge.to && gauge.to < lengths_[w] * (1 - 1e-9))) {
                continue;
            }
            const auto last = static_cast<std::size_t>(gauge.bins) - 1;
            const auto bin = static_cast<std::size_t>((at - gauge.from) / (gauge.to - gauge.from) * gauge.bins);
            note(first_[k] + (bin < last ? bin : last), normal, tangential);
        }
    }

    /// Local. Ends a tile.
    void end_tile() {
        for (const std::size_t bin : in_tile_) {
            for (const std::size_t part : {2 * bin, 2 * bin + 1}) {
                sums_[part].add(tile_[part]);
                tile_[part] = 0;
            }
            touched_[bin] = false;
        }
        in_tile_.clear();
    }

    /// Calls f(ExactSum&) for each sum, in the same order on every rank; of one gauge.
    template <class F>
    void for_each_sum(std::size_t gauge, F&& f) {
        const std::size_t n = 2 * static_cast<std::size_t>(gauges_[gauge].bins);
        for (std::size_t k = 2 * first_[gauge]; k < 2 * first_[gauge] + n; ++k) {
            f(sums_[k]);
        }
    }
    template <class F>
    void for_each_sum(F&& f) {
        for (auto& s : sums_) {
            f(s);
        }
    }

    GaugeImpulse impulse(std::size_t gauge, int bin) const {
        const std::size_t k = 2 * (first_[gauge] + static_cast<std::size_t>(bin));
        return {sums_[k].value(), sums_[k + 1].value()};
    }

    const std::vector<Gauge>& gauges() const { return gauges_; }

private:
    /// Of a feature: how far along its wall, and in which direction.
    struct Place {
        double from = 0; ///< [m]
        Vec<D> tangent = Vec<D>::Zero();
    };

    /// Features of a wall are its segments, then its points, each in order. A point between two segments goes by the one
    /// before it.
    void place_features() {
        std::vector<Place> segments;
        std::size_t point = 0;
        double length = 0;
        for (int f = 0; f < walls_->n_features(); ++f) {
            const auto& feature = walls_->feature(2 * f);
            if (!feature.is_point) {
                if (point > 0) { // of the next wall
                    segments.clear();
                    point = 0;
                    length = 0;
                }
                segments.push_back({length, feature.tangent});
                places_.push_back(segments.back());
                length += feature.length;
                lengths_.resize(static_cast<std::size_t>(feature.wall) + 1);
                lengths_.back() = length;
            } else {
                const double at = point < segments.size() ? segments[point].from : length;
                places_.push_back({at, feature.has_before ? feature.before : feature.after});
                ++point;
            }
        }
    }

    void note(std::size_t bin, double normal, double tangential) {
        if (!touched_[bin]) {
            touched_[bin] = true;
            in_tile_.push_back(bin);
        }
        tile_[2 * bin] += normal;
        tile_[2 * bin + 1] += tangential;
    }

    std::vector<Gauge> gauges_;
    const Walls<D>* walls_;
    std::vector<Place> places_;                     ///< by feature
    std::vector<double> lengths_;                   ///< of walls [m]
    std::vector<std::vector<std::size_t>> of_wall_; ///< gauges
    std::vector<std::size_t> first_;                ///< bin of a gauge
    std::vector<ExactSum> sums_;                    ///< two a bin
    std::vector<double> tile_;
    std::vector<bool> touched_;
    std::vector<std::size_t> in_tile_;
};

} // namespace nappe
