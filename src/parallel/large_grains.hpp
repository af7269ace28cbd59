#pragma once
// Large grains among ranks (core/large_grains.hpp has what they are). Every rank that holds a grain which a large one may
// touch *takes part*: it holds all of them, and all large grains, and computes their contacts with the same arithmetic
// when the velocities of a pass have been exchanged. So nothing needs to be sent afterwards, and copies stay equal.

#include "core/contact_set.hpp"
#include "core/state.hpp"
#include "parallel/communicator.hpp"

#include <vector>

namespace nappe {

template <int D>
class LargeGrains {
public:
    /// **Collective.** Takes note of the large grains among the owned ones, those of a new sample. Others can not come.
    void find(const Communicator& comm, const State<D>& state);

    bool any() const { return n_ > 0; }

    /// **Collective.** At a rebuild, when owned rows are in place (x = x_ref): tells every rank where the large ones are.
    void gather(const Communicator& comm, const State<D>& state);

    /// Local. Whether a large grain may touch this one before the next rebuild. Pre: gather, and the grain is not large.
    bool may_touch(const Vec<D>& x_ref, double reach) const;

    /// **Collective.** @param holds of each rank, whether it holds a grain that may be touched, as far as this rank knows;
    /// owners of large grains are added here.
    void agree(const Communicator& comm, const State<D>& state, std::vector<std::int64_t> holds);
    const std::vector<int>& ranks() const { return ranks_; } ///< that take part, ascending

    /// **Collective.** The impulses that ranks remember of the contacts of large grains, by the present rows of owned
    /// grains: all ranks' become known to each.
    void share(const Communicator& comm, const State<D>& state, ContactMemory<D>& memory) const;

private:
    struct Place {
        GlobalId id;
        std::array<double, D> x;
        double reach;
    };
    std::int64_t n_ = 0; ///< of all ranks
    std::vector<Place> places_;
    std::vector<int> ranks_;
};

} // namespace nappe
