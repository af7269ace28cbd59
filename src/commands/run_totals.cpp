#include "commands/run_totals.hpp"

#include "core/exact_sum.hpp"

namespace nappe {

RunTotals& RunTotals::operator+=(const RunTotals& o) {
    relaxations += o.relaxations;
    messages += o.messages;
    message_bytes += o.message_bytes;
    sweeping += o.sweeping;
    for (std::size_t k = 0; k < n_timed; ++k) {
        by_stage[k] += o.by_stage[k];
    }
    all += o.all;
    loading += o.loading;
    checkpoints += o.checkpoints;
    writing += o.writing;
    restarts += o.restarts;
    return *this;
}

nlohmann::ordered_json to_json(RunTotals totals) {
    nlohmann::ordered_json json;
    totals.for_each([&](const char* name, auto& value) { json[name] = value; });
    return json;
}

RunTotals totals_from(const nlohmann::ordered_json& json) {
    RunTotals totals;
    totals.for_each([&](const char* name, auto& value) { json.at(name).get_to(value); });
    return totals;
}

RunTotals totals_of(Simulation<2>& simulation) {
    const auto& comm = simulation.comm();
    const auto& traffic = simulation.domain().halo().traffic();
    const auto at = [](Timed t) { return static_cast<std::size_t>(t); };
    RunTotals totals;
    totals.relaxations = comm.sum(simulation.counters().relaxations);
    totals.messages = comm.sum(traffic.messages_sent);
    totals.message_bytes = comm.sum(traffic.bytes_sent);
    auto seconds = simulation.watch().seconds();
    ExactSum sweeping;
    sweeping.add(seconds[at(Timed::sweep)]);
    comm.sum(sweeping.limbs());
    totals.sweeping = sweeping.value();
    seconds[at(Timed::sweep)] -= seconds[at(Timed::exchange)];
    for (std::size_t k = 0; k < n_timed; ++k) {
        totals.by_stage[k] = comm.max(seconds[k]);
    }
    return totals;
}

} // namespace nappe
