#include "commands/measurer.hpp"

#include "commands/grain_figures.hpp"
#include "core/error.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <iterator>
#include <numbers>
#include <regex>
#include <system_error>

namespace nappe {

void Measurer::forget(const std::filesystem::path& folder) {
    const std::regex ours(R"((whole|blocks|surface|zone|cell-.*)\.csv|fields-[0-9]+\.hdf)");
    std::error_code ignored;
    std::vector<std::filesystem::path> old;
    for (const auto& place : {folder, folder / "fields"}) {
        for (const auto& entry : std::filesystem::directory_iterator(place, ignored)) {
            if (std::regex_match(entry.path().filename().string(), ours)) {
                old.push_back(entry.path());
            }
        }
    }
    for (const auto& path : old) {
        std::filesystem::remove(path, ignored);
    }
}

Measurer::Measurer(const Communicator& comm, const Scene<2>& scene, const std::filesystem::path& folder)
    : comm_(comm), scene_(scene), flow_(comm, scene_, folder) { // which makes the folder
    if (comm.is_root()) {
        for (const auto& cell : scene.output.cells) {
            sets_.emplace_back(folder / ("cell-" + cell.name + ".csv"), SetFigures::names());
        }
        sets_.emplace_back(folder / "whole.csv", SetFigures::names());
        if (largest_range(scene) > 0) {
            blocks_ = std::make_unique<SeriesWriter>(
                folder / "blocks.csv",
                std::vector<std::string>{"intact", "largest", "detached", "detached_grains", "single"});
        }
    }
    share_errors();
}

/// What the first frame settles for all that follow.
void Measurer::remember(const FrameBlock<2>& first) {
    if (first.step != 0 || first.blocks.n == 0) {
        throw InputError(
            fmt::format("measures begin with the frame of step 0, which must have grains; found step {} with "
                        "{} grains: let the run keep its first frame",
                        first.step, first.blocks.n));
    }
    ExactSum radii;
    for (const auto& row : first.grains) {
        radii.add(row.grain.radius);
    }
    comm_.sum(radii.limbs());
    range_ = scene_.output.measures.range_for(radii.value() / static_cast<double>(first.blocks.n));
}

/// Of every set, over all ranks.
std::vector<SetSums<2>> Measurer::sum_up(const FrameBlock<2>& frame) const {
    const auto figures = grain_figures(comm_, frame, range_);
    const std::size_t n_cells = scene_.output.cells.size();
    std::vector<SetSums<2>> sums(n_cells + 1);
    for (std::size_t i = 0; i < frame.grains.size(); ++i) {
        const auto& of = figures[i];
        const MeasuredGrain<2> grain{&frame.grains[i], &of.load, of.rattler, of.backbone_contacts, of.solid_fraction};
        for (std::size_t k = 0; k < n_cells; ++k) {
            if ((frame.grains[i].grain.cells >> k & 1) != 0) {
                sums[k].add(grain);
            }
        }
        sums.back().add(grain);
    }
    for (auto& set : sums) {
        set.for_each_sum([&](ExactSum& s) { comm_.sum(s.limbs()); });
        comm_.sum(set.counts());
        comm_.max(set.extremes());
    }
    return sums;
}

/// What is left of the bonds of the first frame, and the blocks that hang together by them: on the root, which takes 16
/// bytes a bond for it.
void Measurer::measure_blocks(const FrameBlock<2>& frame, bool is_first) {
    std::vector<BondedPair> bonds; // by (a, b), as contacts are
    for (const auto& c : frame.contacts) {
        if (c.bond != static_cast<std::int32_t>(Bond::none) && c.hi < wall_key) {
            bonds.push_back({c.lo, c.hi});
        }
    }
    if (is_first) {
        first_bonds_ = bonds;
    }
    std::vector<std::vector<BondedPair>> to(static_cast<std::size_t>(comm_.size()));
    std::set_intersection(bonds.begin(), bonds.end(), first_bonds_.begin(), first_bonds_.end(),
                          std::back_inserter(to.front()));
    const auto n_first = comm_.sum(static_cast<std::int64_t>(first_bonds_.size()));
    std::vector<BondedPair> kept;
    for (const auto& part : comm_.exchange(to)) {
        kept.insert(kept.end(), part.begin(), part.end());
    }
    if (blocks_) {
        const auto found = clusters(frame.blocks.n, kept);
        const double intact = static_cast<double>(kept.size()) / static_cast<double>(n_first); // NaN if there was none
        blocks_->append(frame.step, frame.time,
                        std::array{intact, static_cast<double>(found.largest), static_cast<double>(found.detached),
                                   static_cast<double>(found.detached_grains), static_cast<double>(found.single)});
    }
}

void Measurer::measure(FrameBlock<2> frame) {
    // Far from [0, 0] files round positions: a run takes its own measures of what it wrote, as `nappe measure` will.
    shift(frame, Vec<2>(-scene_.origin));
    const bool is_first = references_.empty();
    if (is_first) {
        remember(frame);
    }
    auto sums = sum_up(frame);
    for (std::size_t k = 0; is_first && k < sums.size(); ++k) {
        double phi0 = sums[k].solid_fraction(); // all grains have no circle: what the field says
        if (k < scene_.output.cells.size()) {
            const double radius = scene_.output.cells[k].radius;
            phi0 = sums[k].area() / (std::numbers::pi * radius * radius);
        }
        references_.push_back({phi0, sums[k].extent()});
    }
    if (comm_.is_root()) {
        const double h = impulse_step(scene_, frame.step);
        for (std::size_t k = 0; k < sums.size(); ++k) {
            sets_[k].append(frame.step, frame.time, sums[k].figures(references_[k], h).values());
        }
    }
    if (largest_range(scene_) > 0) {
        measure_blocks(frame, is_first);
    }
    share_errors();
    flow_.measure(frame.step, frame.time, frame.grains, frame.walls);
}

void Measurer::finish() {
    for (auto& writer : sets_) {
        writer.finish();
    }
    if (blocks_) {
        blocks_->finish();
    }
    share_errors();
    flow_.finish();
}

void Measurer::share_errors() {
    std::string error;
    for (const auto& writer : sets_) {
        error = error.empty() ? writer.error() : error;
    }
    if (blocks_ && error.empty()) {
        error = blocks_->error();
    }
    comm_.throw_together<SystemError>(error);
}

} // namespace nappe
