#include "io/xdmf_index.hpp"

#include "core/error.hpp"
#include "io/atomic_file.hpp"

#include <fmt/format.h>

#include <iterator>
#include <span>
#include <string_view>

namespace nappe {

namespace {

/// A dataset as XDMF names it; NumberType and Precision are of the stored element.
struct Field {
    std::string_view name;
    std::string_view path;
    std::string_view number_type;
    int precision;
    int columns;
};

std::string data_item(const FrameEntry& entry, const Field& field, std::int64_t rows) {
    const std::string size = field.columns == 1 ? fmt::format("{}", rows) : fmt::format("{} {}", rows, field.columns);
    return fmt::format(R"(<DataItem Format="HDF" NumberType="{}" Precision="{}" Dimensions="{}">{}:{}</DataItem>)",
                       field.number_type, field.precision, size, entry.file.generic_string(), field.path);
}

/// One uniform grid of vertices, with its attributes.
void append_grid(std::string& text, std::string_view name, const FrameEntry& entry, std::int64_t rows,
                 const Field& connectivity, const Field& points, std::span<const Field> fields) {
    auto out = std::back_inserter(text);
    fmt::format_to(out, "      <Grid Name=\"{}\" GridType=\"Uniform\">\n        <Time Value=\"{}\"/>\n", name,
                   entry.time);
    fmt::format_to(out,
                   "        <Topology TopologyType=\"Polyvertex\" NumberOfElements=\"{}\" NodesPerElement=\"1\">\n"
                   "          {}\n        </Topology>\n",
                   rows, data_item(entry, connectivity, rows));
    fmt::format_to(out, "        <Geometry GeometryType=\"XYZ\">\n          {}\n        </Geometry>\n",
                   data_item(entry, points, rows));
    for (const auto& field : fields) {
        fmt::format_to(out,
                       "        <Attribute Name=\"{}\" AttributeType=\"{}\" Center=\"Node\">\n          {}\n"
                       "        </Attribute>\n",
                       field.name,
                       field.columns == 3   ? "Vector"
                       : field.columns == 1 ? "Scalar"
                                            : "Matrix",
                       data_item(entry, field, rows));
    }
    text += "      </Grid>\n";
}

std::string collection(std::string_view name, const std::string& grids) {
    return fmt::format("<?xml version=\"1.0\" encoding=\"utf-8\"?>\n<Xdmf Version=\"3.0\">\n  <Domain>\n"
                       "    <Grid Name=\"{}\" GridType=\"Collection\" CollectionType=\"Temporal\">\n{}"
                       "    </Grid>\n  </Domain>\n</Xdmf>\n",
                       name, grids);
}

} // namespace

std::string grain_index(const std::vector<FrameEntry>& entries, int dimension) {
    const int spin_columns = dimension * (dimension - 1) / 2;
    const Field connectivity{"", "/VTKHDF/Connectivity", "Int", 8, 1};
    const Field points{"", "/VTKHDF/Points", "Float", 8, 3};
    const std::vector<Field> fields{
        {"id", "/VTKHDF/PointData/id", "Int", 8, 1},
        {"velocity", "/VTKHDF/PointData/velocity", "Float", 8, 3},
        {"spin", "/VTKHDF/PointData/spin", "Float", 8, spin_columns},
        {"rotation", "/VTKHDF/PointData/rotation", "Float", 8, spin_columns},
        {"radius", "/VTKHDF/PointData/radius", "Float", 8, 1},
        {"layer", "/VTKHDF/PointData/layer", "Int", 4, 1},
        {"coordination", "/VTKHDF/PointData/coordination", "Int", 4, 1},
        {"pressure", "/VTKHDF/PointData/pressure", "Float", 8, 1},
        {"rank", "/VTKHDF/PointData/rank", "Int", 4, 1},
    };
    std::string grids;
    for (const auto& entry : entries) {
        append_grid(grids, "grains", entry, entry.n_grains, connectivity, points, fields);
    }
    return collection("grains", grids);
}

std::string contact_index(const std::vector<FrameEntry>& entries, int dimension) {
    const Field connectivity{"", "/contacts/index", "Int", 8, 1};
    const Field points{"", "/contacts/point", "Float", 8, 3};
    const std::vector<Field> fields{
        {"lo", "/contacts/lo", "Int", 8, 1},
        {"hi", "/contacts/hi", "Int", 8, 1},
        {"wall", "/contacts/wall", "Int", 4, 1},
        {"normal", "/contacts/normal", "Float", 8, 3},
        {"gap", "/contacts/gap", "Float", 8, 1},
        {"r_n", "/contacts/r_n", "Float", 8, 1},
        {"r_t", "/contacts/r_t", "Float", 8, dimension - 1},
        {"status", "/contacts/status", "Int", 4, 1},
    };
    std::string grids;
    for (const auto& entry : entries) {
        if (entry.n_contacts > 0) {
            append_grid(grids, "contacts", entry, entry.n_contacts, connectivity, points, fields);
        }
    }
    return collection("contacts", grids);
}

XdmfIndex::XdmfIndex(std::filesystem::path folder, int dimension) : folder_(std::move(folder)), dimension_(dimension) {}

void XdmfIndex::add(const Communicator& comm, const FrameEntry& entry) {
    entries_.push_back(entry);
    write(comm);
}

void XdmfIndex::resume(const Communicator& comm, std::vector<FrameEntry> entries) {
    entries_ = std::move(entries);
    write(comm);
}

void XdmfIndex::write(const Communicator& comm) const {
    std::string error;
    if (comm.is_root()) {
        try {
            write_file_atomically(folder_ / "run.xdmf", grain_index(entries_, dimension_));
            write_file_atomically(folder_ / "contacts.xdmf", contact_index(entries_, dimension_));
        } catch (const std::exception& failure) {
            error = failure.what();
        }
    }
    comm.throw_together<SystemError>(error);
}

} // namespace nappe
