#include "commands/sensors.hpp"

#include "core/error.hpp"
#include "core/initial_grains.hpp"
#include "io/exact_json.hpp"

#include <fmt/format.h>

#include <array>

namespace nappe {

Sensors::Sensors(Simulation<2>& simulation, const std::filesystem::path& folder, const nlohmann::ordered_json* state,
                 const nlohmann::ordered_json* bytes)
    : simulation_(simulation) {
    const auto& output = simulation.scene().output;
    const auto open = [&](const std::string& name, const std::vector<std::string>& columns) {
        const auto path = folder / "series" / (name + ".csv");
        return state != nullptr ? SeriesWriter(path, columns, bytes->at(name).get<std::int64_t>())
                                : SeriesWriter(path, columns);
    };
    if (simulation.comm().is_root()) {
        for (const auto& gauge : output.gauges) {
            std::vector<std::string> columns;
            for (int bin = 0; bin < gauge.bins; ++bin) {
                columns.push_back(fmt::format("normal_{}", bin));
                columns.push_back(fmt::format("tangential_{}", bin));
            }
            gauge_series_.push_back(open("gauge-" + gauge.name, columns));
        }
        for (const auto& probe : output.probes) {
            probe_series_.push_back(open("probe-" + probe.name, {"x", "y", "vx", "vy", "spin", "penetration"}));
        }
    }
    last_of_gauge_.resize(output.gauges.size());
    last_of_probe_.resize(output.probes.size());
    start_.assign(output.probes.size(), Vec<2>::Zero());
    if (state == nullptr) {
        return;
    }
    const auto take = [&](const char* key, std::vector<Last>& lasts) {
        for (std::size_t k = 0; k < lasts.size(); ++k) {
            const auto& row = state->at(key).at(k);
            lasts[k] = {row.at(0).get<std::int64_t>(), from_exact(row.at(1))};
        }
    };
    take("gauges", last_of_gauge_);
    take("probes", last_of_probe_);
    for (std::size_t k = 0; k < start_.size(); ++k) {
        const auto& row = state->at("probes").at(k);
        start_[k] = Vec<2>(from_exact(row.at(2)), from_exact(row.at(3)));
    }
}

nlohmann::ordered_json Sensors::state() const {
    nlohmann::ordered_json json;
    auto& gauges = json["gauges"] = nlohmann::ordered_json::array();
    for (const auto& last : last_of_gauge_) {
        gauges.push_back({last.step, exact(last.time)});
    }
    auto& probes = json["probes"] = nlohmann::ordered_json::array();
    for (std::size_t k = 0; k < last_of_probe_.size(); ++k) {
        const auto& last = last_of_probe_[k];
        probes.push_back({last.step, exact(last.time), exact(start_[k][0]), exact(start_[k][1])});
    }
    return json;
}

void Sensors::begin(double h) {
    check_probes(simulation_);
    const auto& probes = simulation_.scene().output.probes;
    for (std::size_t k = 0; k < probes.size(); ++k) {
        const auto seen = look(k);
        start_[k] = Vec<2>(seen.x[0], seen.x[1]);
    }
    for (auto& last : last_of_gauge_) {
        last.time = -h;
    }
    write(0, 0.0, true);
}

bool Sensors::due(std::int64_t step, int every, const Last& last, bool all) const {
    const int steps = every > 0 ? every : simulation_.scene().output.series_every;
    return last.step != step && (all || step % steps == 0);
}

bool Sensors::write(std::int64_t step, double time, bool all) {
    const auto& output = simulation_.scene().output;
    bool any = false;
    for (std::size_t k = 0; k < output.gauges.size(); ++k) {
        auto& last = last_of_gauge_[k];
        if (due(step, output.gauges[k].every, last, all)) {
            write_gauge(k, step, time, time - last.time);
            last = {step, time};
            any = true;
        }
    }
    for (std::size_t k = 0; k < output.probes.size(); ++k) {
        auto& last = last_of_probe_[k];
        if (due(step, output.probes[k].every, last, all)) {
            write_probe(k, step, time);
            last = {step, time};
            any = true;
        }
    }
    return any;
}

void Sensors::write_gauge(std::size_t gauge, std::int64_t step, double time, double interval) {
    const auto& comm = simulation_.comm();
    const auto& asked = simulation_.scene().output.gauges[gauge];
    auto& sums = simulation_.sums().gauges();
    std::vector<std::int64_t> limbs;
    sums.for_each_sum(gauge, [&](ExactSum& s) { limbs.insert(limbs.end(), s.limbs().begin(), s.limbs().end()); });
    comm.sum(limbs);
    auto from = limbs.begin();
    sums.for_each_sum(gauge, [&](ExactSum& s) {
        for (auto& limb : s.limbs()) {
            limb = *from++;
        }
    });
    if (comm.is_root()) {
        const double width = (asked.to - asked.from) / asked.bins;
        std::vector<double> row;
        for (int bin = 0; bin < asked.bins; ++bin) {
            const auto impulse = sums.impulse(gauge, bin);
            row.push_back(impulse.normal / (interval * width));
            row.push_back(impulse.tangential / (interval * width));
        }
        gauge_series_[gauge].append(step, time, row);
    }
    sums.for_each_sum(gauge, [](ExactSum& s) { s.clear(); });
}

/// Collective. Where a probe's grain is, from its owner.
Sensors::Seen Sensors::look(std::size_t probe) const {
    const auto& state = simulation_.state();
    GlobalId grain = simulation_.scene().output.probes[probe].grain;
    grain += grain < 0 ? simulation_.domain().n_grains() : 0;
    std::vector<Seen> mine;
    for (LocalId i = 0; i < state.n_own; ++i) {
        if (state.id[i] == grain) {
            const auto& u = state.u[i];
            mine.push_back({1, {state.x[i][0], state.x[i][1]}, {u.v[0], u.v[1]}, u.s[0] / state.radius[i]});
        }
    }
    const auto all = simulation_.comm().all_gather(mine);
    return all.empty() ? Seen() : all.front();
}

/// How far the grain has gone the way gravity pulls, or downwards where there is none.
void Sensors::write_probe(std::size_t probe, std::int64_t step, double time) {
    const auto& scene = simulation_.scene();
    const auto seen = look(probe);
    if (!simulation_.comm().is_root()) {
        return;
    }
    const double g = scene.gravity.norm();
    const Vec<2> down = g > 0 ? Vec<2>(scene.gravity / g) : Vec<2>(0, -1);
    const double penetration = (Vec<2>(seen.x[0], seen.x[1]) - start_[probe]).dot(down);
    probe_series_[probe].append(step, time,
                                std::array{seen.x[0] + scene.origin[0], seen.x[1] + scene.origin[1], seen.v[0],
                                           seen.v[1], seen.spin, penetration});
}

void check_probes(const Simulation<2>& simulation, std::int64_t to_come) {
    const auto n = simulation.domain().n_grains() + to_come;
    for (const auto& probe : simulation.scene().output.probes) {
        if (const auto fault = probe_fault(probe, n); !fault.empty()) {
            throw InputError(fmt::format("{}: {}", probe.place, fault));
        }
    }
}

} // namespace nappe
