// What a message costs here, for tools/scaling_model: half a round trip between ranks 0 and 1 by size, the time a rank
// spends posting and completing a message that has long arrived, and an Allreduce of one integer. The way is the
// halo's: non-blocking pairs and a Waitall. Usage: tools/mpirun -n 2 benchmark.ping_pong > messages.json
#include "parallel/communicator.hpp"

#include <algorithm>
#include <chrono>
#include <cstdio>
#include <vector>

namespace {

constexpr int tag = 7;
constexpr int n_repeats = 2000;
constexpr int n_batches = 15; ///< the quartiles of their means are printed: shared machines have quiet moments

double now() {
    return std::chrono::duration<double>(std::chrono::steady_clock::now().time_since_epoch()).count();
}

struct Quartiles {
    double low = 0, median = 0;
};

/// Of the mean time of one call of f, over batches [s].
template <class F>
Quartiles time_of(int repeats, F&& f) {
    std::vector<double> means;
    for (int b = 0; b < n_batches; ++b) {
        const double start = now();
        for (int k = 0; k < repeats; ++k) {
            f();
        }
        means.push_back((now() - start) / repeats);
    }
    std::sort(means.begin(), means.end());
    return {means[n_batches / 4], means[n_batches / 2]};
}

/// Both send and receive at once, as two neighbours do after a colour: one call is one message each way.
Quartiles exchange(const nappe::Communicator& world, std::size_t bytes) {
    const int other = 1 - world.rank();
    std::vector<char> out(bytes), in(bytes);
    return time_of(bytes > 100000 ? n_repeats / 20 : n_repeats, [&] {
        MPI_Request requests[2];
        MPI_Irecv(in.data(), static_cast<int>(bytes), MPI_BYTE, other, tag, world.handle(), &requests[0]);
        MPI_Isend(out.data(), static_cast<int>(bytes), MPI_BYTE, other, tag, world.handle(), &requests[1]);
        MPI_Waitall(2, requests, MPI_STATUSES_IGNORE);
    });
}

/// Rank 0 sends, rank 1 answers: half of one call is the way of one message.
Quartiles half_round_trip(const nappe::Communicator& world, std::size_t bytes) {
    std::vector<char> buffer(bytes);
    const auto send = [&] {
        MPI_Send(buffer.data(), static_cast<int>(bytes), MPI_BYTE, 1 - world.rank(), tag, world.handle());
    };
    const auto receive = [&] {
        MPI_Recv(buffer.data(), static_cast<int>(bytes), MPI_BYTE, 1 - world.rank(), tag, world.handle(),
                 MPI_STATUS_IGNORE);
    };
    const auto whole = time_of(bytes > 100000 ? n_repeats / 20 : n_repeats, [&] {
        if (world.is_root()) {
            send();
            receive();
        } else {
            receive();
            send();
        }
    });
    return {whole.low / 2, whole.median / 2};
}

} // namespace

int main(int argc, char** argv) {
    nappe::MpiSession mpi(argc, argv);
    const nappe::Communicator world;
    if (world.size() != 2) {
        if (world.is_root()) {
            std::fprintf(stderr, "ping_pong: takes two ranks, found %d; start it as tools/mpirun -n 2\n", world.size());
        }
        return 2;
    }
    const auto say = [&](const char* text) {
        if (world.is_root()) {
            std::printf("%s", text);
        }
    };
    say("{\"messages\": [\n");
    const std::size_t sizes[] = {8, 240, 1200, 2400, 4800, 9600, 24000, 48000, 96000, 240000, 960000};
    for (const auto bytes : sizes) {
        const auto one_way = half_round_trip(world, bytes);
        const auto both = exchange(world, bytes);
        char row[200];
        std::snprintf(row, sizeof row, "  {\"bytes\": %zu, \"one_way\": [%.4g, %.4g], \"exchange\": [%.4g, %.4g]}%s\n",
                      bytes, one_way.low, one_way.median, both.low, both.median, bytes == sizes[10] ? "" : ",");
        say(row);
    }
    const auto reduced = time_of(n_repeats, [&] { world.max(std::int64_t{1}); });
    char tail[100];
    std::snprintf(tail, sizeof tail, "], \"allreduce\": [%.4g, %.4g]}\n", reduced.low, reduced.median);
    say(tail);
    return 0;
}
