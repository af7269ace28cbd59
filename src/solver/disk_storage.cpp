// Where packed contacts are kept: a tile's batches one after the other, with room for some more.

#include "solver/disk_contacts.hpp"

#include <algorithm>

namespace nappe {

/// An empty storage for these candidates, and their pairs with walls.
void DiskContacts::lay_out(const Step& step) {
    const auto& candidates = step.candidates;
    const auto n_tiles = candidates.tiles.size();
    const auto most = static_cast<std::size_t>(candidates.size()) / n_lanes + (3 + spare_batches) * n_tiles;
    batches_.clear();
    batches_.reserve(most); // address space: what is not used is never touched
    source_.clear();
    source_.reserve(most * n_lanes);
    tangent_.clear();
    friction_.clear();
    cohesion_.clear();
    kept_gaps_.clear();
    summed_.clear();
    springs_.clear();
    tangent_after_.clear();
    walls_.clear();
    asleep_.resize(static_cast<std::size_t>(candidates.size()));
    ranges_.assign(n_tiles, {});
    n_counted_ = candidates.counted_tiles().size();
    last_.assign(static_cast<std::size_t>(step.state.n_held()), 0);
    n_packed_ = 1;
    n_active_ = 0;
    for (std::size_t t = 0; t < n_tiles; ++t) {
        ranges_[t].walls_begin = static_cast<std::int32_t>(walls_.size());
        for (auto c = candidates.tiles[t].candidates_begin; c < candidates.tiles[t].candidates_end; ++c) {
            if (candidates.b[c] >= step.state.n_held()) {
                walls_.push_back({c, false, -1});
            }
        }
        ranges_[t].candidates_begin = candidates.tiles[t].candidates_begin;
        ranges_[t].n_candidates = candidates.tiles[t].candidates_end - candidates.tiles[t].candidates_begin;
        ranges_[t].bodies = {4 * std::int64_t{candidates.tiles[t].grains_begin},
                             4 * std::int64_t{candidates.tiles[t].grains_end}};
        ranges_[t].n_walls = static_cast<std::int32_t>(walls_.size()) - ranges_[t].walls_begin;
    }
}

/// Batches at the end of the storage for its last tile.
void DiskContacts::grow(Range& range, std::int64_t n) {
    range.room += n;
    batches_.resize(static_cast<std::size_t>(range.begin + range.room));
    source_.resize(batches_.size() * n_lanes, -1);
    if (laws_.features.friction) {
        tangent_.resize(batches_.size());
    }
    if (laws_.features.mixed_friction) {
        friction_.resize(batches_.size());
    }
    if (cohesive_) {
        cohesion_.resize(batches_.size());
    }
    if (keeps_gaps_) {
        kept_gaps_.resize(batches_.size());
    }
    if (sums()) {
        summed_.resize(batches_.size());
    }
    if (smooth_) {
        springs_.resize(batches_.size());
        tangent_after_.resize(tangent_.size());
    }
}

/// Eight null contacts.
void DiskContacts::clear(std::int64_t at, LocalId null_body) {
    DiskBatch& batch = batches_[static_cast<std::size_t>(at)];
    batch = {};
    std::fill(std::begin(batch.a), std::end(batch.a), 4u * static_cast<std::uint32_t>(null_body));
    std::fill(std::begin(batch.b), std::end(batch.b), 4u * static_cast<std::uint32_t>(null_body));
    std::fill_n(source_.begin() + at * n_lanes, n_lanes, -1);
    if (laws_.features.friction) {
        tangent_[static_cast<std::size_t>(at)] = {};
    }
    if (cohesive_) {
        cohesion_[static_cast<std::size_t>(at)] = {};
    }
    if (keeps_gaps_) {
        kept_gaps_[static_cast<std::size_t>(at)] = {};
    }
    if (smooth_) {
        springs_[static_cast<std::size_t>(at)] = {};
    }
}

void DiskContacts::advance(const std::vector<BodyVelocity<2>>& u, double h) {
    for (const auto& range : ranges_) {
        kernels_->advance(span(range), doubles(u), h);
    }
}

void DiskContacts::begin_correction(const std::vector<BodyVelocity<2>>& u, double h, double share) {
    corrections_.resize(batches_.size());
    for (const auto& range : ranges_) {
        kernels_->begin_correction(span(range), corrections_.data() + range.begin, doubles(u), h, share);
    }
}

void DiskContacts::round_batches() {
    single_.resize(batches_.size());
    for (std::size_t t = 0; t < ranges_.size(); ++t) {
        kernels_->round_batches(span(ranges_[t]), single_of(t));
    }
}

void DiskContacts::start_cold() {
    for (auto& batch : batches_) {
        std::fill(std::begin(batch.r_n), std::end(batch.r_n), 0.0);
    }
    std::fill(tangent_.begin(), tangent_.end(), TangentBatch{});
}

void DiskContacts::remember(int n) {
    memory_[0].resize(n > 0 ? batches_.size() : 0);
    memory_[1].assign(n > 1 ? batches_.size() : 0, SearchBatch{});
    for (std::size_t k = 0; k < memory_[0].size(); ++k) {
        for (int l = 0; l < n_lanes; ++l) {
            memory_[0][k].n[l] = batches_[k].r_n[l];
            memory_[0][k].t[l] = tangential(static_cast<std::int64_t>(k), l);
        }
    }
}

void DiskContacts::store(CandidateSet<2>& candidates) const {
    for (std::size_t t = 0; t < ranges_.size() && !fresh_; ++t) {
        store_tile(t, candidates);
    }
}

void DiskContacts::store_tile(std::size_t tile, CandidateSet<2>& candidates) const {
    // By lane, and nothing twice: every step does this.
    const auto& of = candidates.tiles[tile];
    const Range& range = ranges_[tile];
    if (!range.others_are_zero) {
        const auto n = of.candidates_end - of.candidates_begin;
        std::fill_n(candidates.r_n.begin() + of.candidates_begin, n, 0.0);
        if (!candidates.r_t.empty()) {
            std::fill_n(candidates.r_t.begin() + of.candidates_begin, n, std::array{0.0});
        }
        range.others_are_zero = true;
    }
    double* const r_n = candidates.r_n.data();
    std::array<double, 1>* const r_t = candidates.r_t.data();
    for (auto k = static_cast<std::size_t>(range.begin); k < static_cast<std::size_t>(range.begin + range.n); ++k) {
        const std::int32_t* const source = &source_[k * n_lanes];
        for (std::size_t l = 0; l < n_lanes; ++l) {
            if (source[l] >= 0) {
                r_n[source[l]] = batches_[k].r_n[l];
            }
        }
        for (std::size_t l = 0; l < n_lanes && !tangent_.empty(); ++l) {
            if (source[l] >= 0) {
                r_t[source[l]][0] = tangent_[k].r_t[l];
            }
        }
    }
}

std::size_t DiskContacts::bytes_swept() const {
    return batches_.size() * sizeof(DiskBatch) + tangent_.size() * sizeof(TangentBatch) +
           friction_.size() * sizeof(FrictionBatch) + cohesion_.size() * sizeof(CohesionBatch) +
           (memory_[0].size() + memory_[1].size()) * sizeof(SearchBatch);
}

std::size_t DiskContacts::bytes_swept_single() const {
    return batches_.size() * sizeof(SingleBatch) + friction_.size() * sizeof(FrictionBatch) +
           cohesion_.size() * sizeof(CohesionBatch);
}

} // namespace nappe
