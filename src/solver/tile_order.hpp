#pragma once
// In which order a rank takes its tiles. A sweep is four phases, one a tile colour, and a tile's phase must come after the
// lower phases of the tiles around it and before their higher ones; any order that holds to this gives the same bits.
//
// So tiles are put into layers such that neighbours differ by one layer at most: layer 0 has the tiles whose grains other
// ranks hold too, a layer's number is the distance from there (on one rank: along the longer axis). Layer d does phase p
// at the moment p + d, lower phases first. Layer 0 then goes first and, while messages fly, the layers behind it do the
// phases before; and as many phases are under way at a time as there are layers between the first and the last of them:
// several sweeps pass over a part of the sample while it is in cache.

#include "core/contact_set.hpp"

#include <array>
#include <vector>

namespace nappe {

template <int D>
class TileOrder {
public:
    static constexpr int n_colours = n_tile_colours<D>;

    /// Local. After a rebuild.
    void build(const CandidateSet<D>& candidates);

    int last_layer() const { return static_cast<int>(layers_.size()) - 1; } ///< 0 at least

    /// Rows of CandidateSet::tiles.
    const std::vector<std::int32_t>& tiles(int layer, int colour) const {
        return layers_[static_cast<std::size_t>(layer)][static_cast<std::size_t>(colour)];
    }

private:
    using Layer = std::array<std::vector<std::int32_t>, n_colours>;
    std::vector<Layer> layers_ = std::vector<Layer>(1);
};

/// Sweeps over `n` layers of this many bytes in all that should pass together, so that what is between the first and the
/// last phase stays in this core's second cache; 1 at least. Never changes a result.
int sweeps_in_cache(double bytes, int n_layers, int phases_per_sweep);

} // namespace nappe
