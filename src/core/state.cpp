#include "core/state.hpp"

#include <limits>

namespace nappe {

template <int D>
void State<D>::assign(const std::vector<GrainRecord<D>>& own, const std::vector<GrainRecord<D>>& ghosts,
                      LocalId n_walls) {
    const std::size_t n = own.size() + ghosts.size();
    const std::size_t bodies = n + static_cast<std::size_t>(n_walls) + 1;
    n_own = static_cast<LocalId>(own.size());
    id.resize(n);
    x.resize(n);
    x_ref.resize(n);
    margin.resize(n);
    rotation.resize(n);
    radius.resize(n);
    mass.resize(n);
    cells.resize(n);
    layer.resize(n);
    BodyPlace<D> nowhere;
    nowhere.radius = std::numeric_limits<double>::quiet_NaN();
    mid.assign(bodies, nowhere);
    mid.back().radius = 0; // the null body touches itself at most
    u.assign(bodies, BodyVelocity<D>{});
    u_old.assign(bodies, BodyVelocity<D>{});
    material.assign(bodies, 0);

    std::size_t i = 0;
    for (const auto* part : {&own, &ghosts}) {
        for (const auto& g : *part) {
            id[i] = g.id;
            for (int d = 0; d < D; ++d) {
                x[i][d] = g.x[d];
            }
            mid[i] = {g.x, g.radius};
            x_ref[i] = x[i];
            margin[i] = g.margin;
            u[i] = g.u;
            u_old[i] = g.u;
            rotation[i] = g.rotation;
            radius[i] = g.radius;
            mass[i] = g.mass;
            cells[i] = g.cells;
            layer[i] = g.layer;
            material[i] = g.material;
            ++i;
        }
    }
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
