#pragma once
// One pass over all tiles that also begins and ends a step for their grains, while these are in cache: a tile is opened
// before any contact may touch its grains, and closed after the last has. In the layers of TileOrder these are two more
// phases, one before the colours and one behind them, and the same rule holds.

#include "core/stopwatch.hpp"
#include "parallel/halo.hpp"
#include "solver/tile_order.hpp"

#include <algorithm>

namespace nappe {

/// **Collective.** open(t), press(t), close(t) for the tiles t of this rank; what press changes in u of grains that others
/// hold is sent to them after each colour. Copies of others' grains are to be opened before and closed behind it.
/// Pre: grains are exchanged after each colour (not Halo::by_sweep, unless the rank is alone).
template <int D, class Open, class Press, class Close>
void fused_pass(const TileOrder<D>& order, bool alone, Stopwatch& watch, Halo<D>& halo, std::vector<BodyVelocity<D>>& u,
                const Open& open, const Press& press, const Close& close) {
    constexpr int n_colours = TileOrder<D>::n_colours;
    const int last = order.last_layer();
    const auto each = [&](int layer, int colour, const auto& visit) {
        for (const std::int32_t t : order.tiles(layer, colour)) {
            visit(static_cast<std::size_t>(t));
        }
    };
    const auto each_of_layer = [&](int layer, const auto& visit) {
        for (int colour = 0; layer >= 0 && layer <= last && colour < n_colours; ++colour) {
            each(layer, colour, visit);
        }
    };
    // Layer d has colour p at the moment d + p; it is opened at d - 1 and closed at d + n_colours + 1, when the last
    // colour of layer d + 1 is done.
    for (int moment = -1; moment <= last + n_colours + 1; ++moment) {
        each_of_layer(moment + 1, open);
        for (int layer = std::min(last, moment); layer > std::max(0, moment - n_colours); --layer) {
            each(layer, moment - layer, press);
        }
        if (!alone && moment > 0 && moment <= n_colours) {
            const auto lap = watch.lap(Timed::exchange);
            halo.finish(u);
        }
        if (moment >= 0 && moment < n_colours) {
            each(0, moment, press);
            if (!alone) {
                const auto lap = watch.lap(Timed::exchange);
                halo.start(moment, u);
            }
        }
        each_of_layer(moment - n_colours - 1, close);
    }
}

} // namespace nappe
