#include "core/state.hpp"

#include "core/error.hpp"

#include <algorithm>
#include <limits>
#include <string>

namespace nappe {

namespace {

/// Rows of one array in a new order.
template <int D, class T, class OfRecord>
void reorder_array(std::vector<T>& array, const std::vector<LocalId>& from, const std::vector<GrainRecord<D>>& arrivals,
                   OfRecord&& of) {
    std::vector<T> ordered(from.size());
    for (std::size_t i = 0; i < from.size(); ++i) {
        ordered[i] = from[i] >= 0 ? array[static_cast<std::size_t>(from[i])]
                                  : of(arrivals[static_cast<std::size_t>(-1 - from[i])]);
    }
    array.swap(ordered);
}

template <int D>
Vec<D> position(const GrainRecord<D>& g) {
    Vec<D> v;
    for (int d = 0; d < D; ++d) {
        v[d] = g.x[d];
    }
    return v;
}

} // namespace

template <int D>
void State<D>::reorder(const std::vector<LocalId>& from, const std::vector<GrainRecord<D>>& arrivals) {
    using Record = GrainRecord<D>;
    bool same = static_cast<LocalId>(from.size()) == n_own;
    for (std::size_t i = 0; same && i < from.size(); ++i) {
        same = from[i] == static_cast<LocalId>(i);
    }
    n_own = static_cast<LocalId>(from.size());
    if (same) {
        return;
    }
    for ([[maybe_unused]] const auto& g : arrivals) {
        NAPPE_ASSERT(carries.turning || (g.u.s == decltype(g.u.s){} && g.rotation == decltype(g.rotation){}),
                     "grain " + std::to_string(g.id) + " turns in a scene where nothing does");
    }
    reorder_array(id, from, arrivals, [](const Record& g) { return g.id; });
    reorder_array(x, from, arrivals, [](const Record& g) { return position(g); });
    reorder_array(margin, from, arrivals, [](const Record& g) { return g.margin; });
    reorder_array(u, from, arrivals, [](const Record& g) { return g.u; });
    reorder_array(radius, from, arrivals, [](const Record& g) { return g.radius; });
    reorder_array(mass, from, arrivals, [](const Record& g) { return g.mass; });
    reorder_array(material, from, arrivals, [](const Record& g) { return g.material; });
    if (carries.turning) {
        reorder_array(rotation, from, arrivals, [](const Record& g) { return g.rotation; });
    }
    if (carries.cells) {
        reorder_array(cells, from, arrivals, [](const Record& g) { return g.cells; });
    }
    if (carries.layers) {
        reorder_array(layer, from, arrivals, [](const Record& g) { return g.layer; });
    }
}

template <int D>
void State<D>::complete(const std::vector<GrainRecord<D>>& ghosts, LocalId n_walls) {
    const auto own = static_cast<std::size_t>(n_own);
    const std::size_t n = own + ghosts.size();
    const std::size_t bodies = n + static_cast<std::size_t>(n_walls) + 1;
    const auto make_room = [](auto& array, std::size_t rows) {
        array.reserve(rows); // or it would take twice what it needs
        array.resize(rows);
    };
    make_room(id, n);
    make_room(x, n);
    make_room(margin, n);
    make_room(rotation, carries.turning ? n : 0);
    make_room(radius, n);
    make_room(mass, n);
    make_room(cells, carries.cells ? n : 0);
    make_room(layer, carries.layers ? n : 0);
    make_room(u, bodies);
    make_room(material, bodies);
    make_room(mid, bodies);
    for (std::size_t k = 0; k < ghosts.size(); ++k) {
        const auto& g = ghosts[k];
        const std::size_t i = own + k;
        id[i] = g.id;
        x[i] = position(g);
        margin[i] = g.margin;
        u[i] = g.u;
        radius[i] = g.radius;
        mass[i] = g.mass;
        material[i] = g.material;
        if (carries.turning) {
            rotation[i] = g.rotation;
        }
        if (carries.cells) {
            cells[i] = g.cells;
        }
        if (carries.layers) {
            layer[i] = g.layer;
        }
    }
    for (std::size_t i = n; i < bodies; ++i) {
        u[i] = {};
        material[i] = 0;
    }
    x_ref = x;
    u_old = u;
    for (std::size_t i = 0; i < n; ++i) {
        for (int d = 0; d < D; ++d) {
            mid[i].x[d] = x[i][d];
        }
        mid[i].radius = radius[i];
    }
    BodyPlace<D> nowhere;
    nowhere.radius = std::numeric_limits<double>::quiet_NaN();
    std::fill(mid.begin() + static_cast<std::ptrdiff_t>(n), mid.end(), nowhere);
    mid.back().radius = 0; // the null body touches itself at most
}

template <int D>
void State<D>::assign(const std::vector<GrainRecord<D>>& own, const std::vector<GrainRecord<D>>& ghosts,
                      LocalId n_walls) {
    std::vector<LocalId> from(own.size());
    for (std::size_t i = 0; i < own.size(); ++i) {
        from[i] = -1 - static_cast<LocalId>(i);
    }
    reorder(from, own);
    complete(ghosts, n_walls);
}

template <int D>
GrainRecord<D> to_record(const GrainRow<D>& row) {
    GrainRecord<D> g;
    g.id = row.id;
    g.u.v = row.v;
    for (int k = 0; k < n_spin<D>; ++k) {
        g.u.s[k] = row.radius * row.spin[k];
    }
    g.u.inv_m = 1.0 / row.mass;
    g.x = row.x;
    g.rotation = row.rotation;
    g.radius = row.radius;
    g.mass = row.mass;
    g.cells = row.cells;
    g.material = row.material;
    g.layer = row.layer;
    return g;
}

template <int D>
GrainRow<D> to_row(const GrainRecord<D>& g) {
    GrainRow<D> row;
    row.id = g.id;
    row.x = g.x;
    row.v = g.u.v;
    for (int k = 0; k < n_spin<D>; ++k) {
        row.spin[k] = g.u.s[k] / g.radius;
    }
    row.rotation = g.rotation;
    row.radius = g.radius;
    row.mass = g.mass;
    row.cells = g.cells;
    row.material = g.material;
    row.layer = g.layer;
    return row;
}

template struct State<2>;
template GrainRecord<2> to_record(const GrainRow<2>&);
template GrainRow<2> to_row(const GrainRecord<2>&);

} // namespace nappe
