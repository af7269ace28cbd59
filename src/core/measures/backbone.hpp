#pragma once
// Which grains carry a packing: rattlers, held by fewer than two contacts, are taken away with their contacts until
// none is left (what remains is the 2-core of the contacts' graph: the order of taking has no influence). Walls stay.

#include "core/measures/grain_loads.hpp"

#include <cstddef>
#include <vector>

namespace nappe {

/// The part of it that one rank does for its block of grains; ranks tell each other which contacts are gone until all
/// have nothing to tell. Every member is Local.
class Backbone {
public:
    /// @param first id of the block's first grain @param n grains of the block @param sides of contacts of these
    /// grains, sorted by (grain, partner); those that carry no impulse do not count
    template <int D>
    Backbone(GlobalId first, std::size_t n, std::span<const ContactSide<D>> sides);

    /// Takes rattlers away as long as the block has any. @returns for each contact with a grain of another block that
    /// is gone with them, that grain; empty: nothing to tell.
    std::vector<GlobalId> take_rattlers();

    /// A contact of a grain of this block is gone, since its partner was taken away elsewhere.
    void lose_contact(GlobalId grain);

    bool is_rattler(std::size_t row) const { return taken_[row]; }
    /// Contacts of a grain with walls and grains that are no rattlers; 0 for rattlers.
    std::int32_t contacts(std::size_t row) const { return taken_[row] ? 0 : count_[row]; }

private:
    GlobalId first_;
    std::vector<std::size_t> begin_; ///< of each row in partners_
    std::vector<GlobalId> partners_;
    std::vector<std::int32_t> count_; ///< contacts that are left
    std::vector<bool> taken_;
    std::vector<std::size_t> doubtful_; ///< rows that may have become rattlers
};

} // namespace nappe
