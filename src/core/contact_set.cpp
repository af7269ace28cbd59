#include "core/contact_set.hpp"

#include <algorithm>

namespace nappe {

namespace {

template <int D>
bool any(const Impulse<D>& r) {
    return r.n != 0 || std::any_of(r.t.begin(), r.t.end(), [](double t) { return t != 0; });
}

template <int D>
bool by_name(const ContactRow<D>& p, const ContactRow<D>& q) {
    return p.lo != q.lo ? p.lo < q.lo : p.hi < q.hi;
}

} // namespace

template <int D>
void ContactMemory<D>::keep(const State<D>& state, const CandidateSet<D>& candidates) {
    from_.clear();
    named_.clear();
    begin_.assign(static_cast<std::size_t>(state.n_own) + 1, 0);
    const auto n = static_cast<std::size_t>(candidates.size());
    const auto is_kept = [&](std::size_t c) { return candidates.a[c] < state.n_own && any<D>(candidates.impulse(c)); };
    for (std::size_t c = 0; c < n; ++c) {
        if (is_kept(c)) { // a large grain's may belong to a ghost
            ++begin_[static_cast<std::size_t>(candidates.a[c])];
        }
    }
    std::int32_t sum = 0;
    for (auto& k : begin_) { // to the end of each row's part, from where it is filled backwards
        k = sum += k;
    }
    partners_.resize(static_cast<std::size_t>(sum));
    for (std::size_t c = n; c-- > 0;) {
        if (is_kept(c)) {
            const auto at = --begin_[static_cast<std::size_t>(candidates.a[c])];
            partners_[static_cast<std::size_t>(at)] = {partner_key(state, candidates.b[c]), candidates.impulse(c)};
        }
    }
}

template <int D>
void ContactMemory<D>::rekey(const State<D>& state) {
    std::vector<std::int32_t> begin{0};
    std::vector<Partner> partners;
    for (LocalId i = 0; i < state.n_own; ++i) {
        for_each(i, state.id[i], [&](GlobalId hi, const Impulse<D>& r) { partners.push_back({hi, r}); });
        begin.push_back(static_cast<std::int32_t>(partners.size()));
    }
    begin_.swap(begin);
    partners_.swap(partners);
    from_.clear();
    named_.clear();
}

template <int D>
void ContactMemory<D>::add(std::vector<ContactRow<D>> rows) {
    if (named_.empty()) {
        named_.swap(rows);
    } else {
        named_.insert(named_.end(), rows.begin(), rows.end());
    }
    std::sort(named_.begin(), named_.end(), by_name<D>);
}

template <int D>
void ContactMemory<D>::set_of_large(std::vector<ContactRow<D>> rows) {
    of_large_ = std::move(rows);
    std::sort(of_large_.begin(), of_large_.end(), by_name<D>);
}

template <int D>
Impulse<D> ContactMemory<D>::find_of_large(GlobalId lo, GlobalId hi) const {
    const auto at = std::lower_bound(of_large_.begin(), of_large_.end(), ContactRow<D>{lo, hi}, by_name<D>);
    return at != of_large_.end() && at->lo == lo && at->hi == hi ? Impulse<D>{at->r_n, at->r_t} : Impulse<D>{};
}

template <int D>
std::size_t ContactMemory<D>::first_named(GlobalId lo) const {
    const auto before = [](const ContactRow<D>& row, GlobalId id) { return row.lo < id; };
    return static_cast<std::size_t>(std::lower_bound(named_.begin(), named_.end(), lo, before) - named_.begin());
}

template <int D>
Impulse<D> ContactMemory<D>::find(LocalId row, GlobalId lo, GlobalId hi) const {
    Impulse<D> found;
    for_each(row, lo, [&](GlobalId partner, const Impulse<D>& r) {
        if (partner == hi) {
            found = r;
        }
    });
    return found;
}

template <int D>
std::vector<ContactRow<D>> impulse_rows(const State<D>& state, const CandidateSet<D>& candidates) {
    std::vector<ContactRow<D>> rows;
    rows.reserve(candidates.a.size());
    for (std::size_t c = 0; c < candidates.a.size(); ++c) {
        const auto r = candidates.impulse(c);
        if (candidates.a[c] < state.n_own && any<D>(r)) {
            const auto a = static_cast<std::size_t>(candidates.a[c]);
            rows.push_back({state.id[a], partner_key(state, candidates.b[c]), r.n, r.t});
        }
    }
    return rows;
}

template class ContactMemory<2>;
template std::vector<ContactRow<2>> impulse_rows(const State<2>&, const CandidateSet<2>&);

} // namespace nappe
