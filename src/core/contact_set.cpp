#include "core/contact_set.hpp"

#include <algorithm>

namespace nappe {

template <int D>
ContactMemory<D>::ContactMemory(std::vector<ContactRow<D>> rows) : rows_(std::move(rows)) {
    const auto before = [](const auto& p, const auto& q) { return p.lo != q.lo ? p.lo < q.lo : p.hi < q.hi; };
    std::sort(rows_.begin(), rows_.end(), before);
    first_.reserve(rows_.size());
    for (std::size_t k = 0; k < rows_.size(); ++k) {
        first_.try_emplace(rows_[k].lo, static_cast<std::int32_t>(k));
    }
}

template <int D>
Impulse<D> ContactMemory<D>::find(GlobalId lo, GlobalId hi) const {
    const auto it = first_.find(lo);
    if (it == first_.end()) {
        return {};
    }
    for (auto k = static_cast<std::size_t>(it->second); k < rows_.size() && rows_[k].lo == lo; ++k) {
        if (rows_[k].hi == hi) {
            return {rows_[k].r_n, rows_[k].r_t};
        }
    }
    return {};
}

template <int D>
std::vector<ContactRow<D>> impulse_rows(const State<D>& state, const CandidateSet<D>& candidates) {
    std::vector<ContactRow<D>> rows;
    rows.reserve(candidates.a.size());
    for (std::size_t c = 0; c < candidates.a.size(); ++c) {
        const auto& r = candidates.r[c];
        bool any = r.n != 0;
        for (const double t : r.t) {
            any = any || t != 0;
        }
        if (any) {
            const auto a = static_cast<std::size_t>(candidates.a[c]);
            rows.push_back({state.id[a], partner_key(state, candidates.b[c]), r.n, r.t});
        }
    }
    return rows;
}

template class ContactMemory<2>;
template std::vector<ContactRow<2>> impulse_rows(const State<2>&, const CandidateSet<2>&);

} // namespace nappe
