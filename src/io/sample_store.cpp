#include "io/sample_store.hpp"

#include "io/checksum.hpp"
#include "io/stored_rows.hpp"
#include "io/summary.hpp"

#include <fmt/format.h>

#include <stdexcept>

namespace nappe {

namespace {

/// Every field of a grain (stored_rows.hpp, visit_contact_fields).
template <int D, class Visit>
void visit_sampled_fields(Visit visit) {
    visit("/grains/id", 1, [](auto& g) { return &g.id; });
    visit("/grains/position", D, [](auto& g) { return g.x.data(); });
    visit("/grains/velocity", D, [](auto& g) { return g.v.data(); });
    visit("/grains/spin", n_spin<D>, [](auto& g) { return g.spin.data(); });
    visit("/grains/rotation", n_spin<D>, [](auto& g) { return g.rotation.data(); });
    visit("/grains/radius", 1, [](auto& g) { return &g.radius; });
    visit("/grains/mass", 1, [](auto& g) { return &g.mass; });
    visit("/grains/cells", 1, [](auto& g) { return &g.cells; });
    visit("/grains/material", 1, [](auto& g) { return &g.material; });
    visit("/grains/layer", 1, [](auto& g) { return &g.layer; });
}

constexpr const char* origin_path = "/made_from";

void add_origin(const Communicator& comm, const SampleOrigin& origin, Hdf5Content& content) {
    add_text(comm, origin_path, origin.made_from, content);
    content.attributes.push_back({"/", "key", origin.key()});
    content.attributes.push_back({"/", "physics_revision", origin.physics_revision});
    content.attributes.push_back({"/", "version", std::string(program_version())});
}

/// This rank's part. Local; throws if the file is not what it should be.
template <int D>
StoredSample<D> read_sample(const Communicator& comm, SlabReader& reader, const SampleOrigin& origin,
                            const StoredManifest& manifest, const RowLimits& limits) {
    const auto& file = reader.file();
    const auto made_from = reader.read_text(comm, origin_path);
    if (file.bits("/", "key") != origin.key() || file.integer("/", "physics_revision") != origin.physics_revision ||
        made_from != origin.made_from) {
        throw std::runtime_error("the file is of another sample");
    }
    const IdBlocks blocks{manifest.n_grains, comm.size()};
    const auto first = blocks.first(comm.rank());
    const auto count = blocks.count(comm.rank());
    reader.expect_rows(manifest);

    StoredSample<D> sample;
    sample.n_grains = manifest.n_grains;
    sample.n_contacts = manifest.n_contacts;
    sample.notes = manifest.notes;
    sample.grains.resize(static_cast<std::size_t>(count));
    visit_sampled_fields<D>(filling(reader, first, sample.grains));
    sample.contacts = reader.read_contacts<D>(first, count, comm.rank() == comm.size() - 1);
    for (const auto& broken :
         {broken_rule<D>(std::span(std::as_const(sample.grains)), first, limits),
          broken_rule<D>(std::span(std::as_const(sample.contacts)), first, count, manifest.n_grains, limits)}) {
        if (!broken.empty()) {
            throw std::runtime_error(broken);
        }
    }
    return sample;
}

} // namespace

std::uint64_t SampleOrigin::key() const {
    return checksum(fmt::format("{}\n{}", physics_revision, made_from));
}

std::filesystem::path sample_path(const std::filesystem::path& folder, const SampleOrigin& origin) {
    return folder / (hex_digits(origin.key()) + ".hdf");
}

template <int D>
void store_sample(const Communicator& comm, const std::filesystem::path& folder, const SampleOrigin& origin,
                  std::vector<GrainRow<D>> grains, std::vector<ContactRow<D>> contacts,
                  const nlohmann::ordered_json& notes) {
    const IdBlocks blocks{comm.sum(static_cast<std::int64_t>(grains.size())), comm.size()};
    grains = grains_in_blocks(comm, blocks, std::move(grains), [](const GrainRow<D>& g) { return g.id; });
    contacts = contacts_in_blocks(comm, blocks, std::move(contacts));
    const RowRange grain_range{blocks.first(comm.rank()), blocks.count(comm.rank()), blocks.n};
    const RowRange contact_range = row_range(comm, contacts.size());

    Hdf5Content content;
    visit_sampled_fields<D>(adding_to(content, grain_range, grains));
    visit_contact_fields<D>(adding_to(content, contact_range, contacts));
    add_offsets(comm, grain_range, contact_range, contacts, content);
    add_origin(comm, origin, content);
    add_checksums(comm, content);
    write_stored(comm, sample_path(folder, origin), content,
                 {origin.key(), origin.physics_revision, blocks.n, contact_range.total, 0, 0, notes});
}

template <int D>
SampleLookup<D> load_sample(const Communicator& comm, const std::filesystem::path& folder, const SampleOrigin& origin,
                            const RowLimits& limits) {
    const auto path = sample_path(folder, origin);
    const auto file = examine_stored(comm, path);
    if (!file.reason.empty()) {
        return {std::nullopt, file.reason};
    }
    if (file.manifest.key != origin.key()) {
        return {std::nullopt, path.string() + ": the manifest is of another sample"};
    }
    StoredSample<D> sample;
    const auto reason = read_stored(
        comm, path, [&](SlabReader& reader) { sample = read_sample<D>(comm, reader, origin, file.manifest, limits); });
    return reason.empty() ? SampleLookup<D>{std::move(sample), {}} : SampleLookup<D>{std::nullopt, reason};
}

template void store_sample<2>(const Communicator&, const std::filesystem::path&, const SampleOrigin&,
                              std::vector<GrainRow<2>>, std::vector<ContactRow<2>>, const nlohmann::ordered_json&);
template SampleLookup<2> load_sample<2>(const Communicator&, const std::filesystem::path&, const SampleOrigin&,
                                        const RowLimits&);

} // namespace nappe
