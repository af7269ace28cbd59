#include "parallel/communicator.hpp"

#include <algorithm>
#include <chrono>
#include <cstdlib>
#include <limits>
#include <thread>

namespace nappe {

namespace {

constexpr int exchange_tag = 11;

/// MPI 3 counts are int; a longer message goes in several pieces.
constexpr std::size_t piece = std::size_t{1} << 30;

} // namespace

MpiSession::MpiSession(int& argc, char**& argv) {
    // Open MPI keeps a helper file in TMPDIR for every file that ranks open together, and dies or hangs where that is
    // full. nappe uses no shared file pointers, so the helper is never needed; a value set by the user stands.
    setenv("OMPI_MCA_sharedfp", "individual", 0);
    MPI_Init(&argc, &argv);
}

MpiSession::~MpiSession() {
    MPI_Finalize();
}

std::string mpi_library() {
    std::string text(MPI_MAX_LIBRARY_VERSION_STRING, '\0');
    int length = 0;
    MPI_Get_library_version(text.data(), &length);
    text.resize(static_cast<std::size_t>(length));
    return text.substr(0, text.find_first_of(",\n")); // what follows names the machine it was built on
}

Communicator::Communicator(MPI_Comm parent) {
    MPI_Comm_dup(parent, &handle_);
    MPI_Comm_rank(handle_, &rank_);
    MPI_Comm_size(handle_, &size_);
}

Communicator::~Communicator() {
    if (handle_ != MPI_COMM_NULL) {
        MPI_Comm_free(&handle_);
    }
}

Communicator::Communicator(Communicator&& other) noexcept
    : handle_(other.handle_), rank_(other.rank_), size_(other.size_) {
    other.handle_ = MPI_COMM_NULL;
}

void Communicator::abort(int code) const {
    MPI_Abort(handle_, code);
    std::abort();
}

void Communicator::barrier() const {
    MPI_Barrier(handle_);
}

void Communicator::sleepy_barrier() const {
    MPI_Request request;
    MPI_Ibarrier(handle_, &request);
    for (int done = 0;;) {
        MPI_Test(&request, &done, MPI_STATUS_IGNORE);
        if (done != 0) {
            return;
        }
        std::this_thread::sleep_for(std::chrono::milliseconds(1));
    }
}

std::int64_t Communicator::sum(std::int64_t value) const {
    MPI_Allreduce(MPI_IN_PLACE, &value, 1, MPI_INT64_T, MPI_SUM, handle_);
    return value;
}

std::uint64_t Communicator::sum_wrapping(std::uint64_t value) const {
    MPI_Allreduce(MPI_IN_PLACE, &value, 1, MPI_UINT64_T, MPI_SUM, handle_);
    return value;
}

void Communicator::sum(std::span<std::int64_t> values) const {
    MPI_Allreduce(MPI_IN_PLACE, values.data(), static_cast<int>(values.size()), MPI_INT64_T, MPI_SUM, handle_);
}

double Communicator::max(double value) const {
    MPI_Allreduce(MPI_IN_PLACE, &value, 1, MPI_DOUBLE, MPI_MAX, handle_);
    return value;
}

std::int64_t Communicator::max(std::int64_t value) const {
    MPI_Allreduce(MPI_IN_PLACE, &value, 1, MPI_INT64_T, MPI_MAX, handle_);
    return value;
}

void Communicator::max(std::span<double> values) const {
    MPI_Allreduce(MPI_IN_PLACE, values.data(), static_cast<int>(values.size()), MPI_DOUBLE, MPI_MAX, handle_);
}

std::uint32_t Communicator::bit_or(std::uint32_t flags) const {
    MPI_Allreduce(MPI_IN_PLACE, &flags, 1, MPI_UINT32_T, MPI_BOR, handle_);
    return flags;
}

void Communicator::broadcast(std::span<std::byte> bytes, int root) const {
    for (std::size_t at = 0; at < bytes.size(); at += piece) {
        const auto n = std::min(piece, bytes.size() - at);
        MPI_Bcast(bytes.data() + at, static_cast<int>(n), MPI_BYTE, root, handle_);
    }
}

void Communicator::broadcast(std::string& text, int root) const {
    std::int64_t length = static_cast<std::int64_t>(text.size());
    MPI_Bcast(&length, 1, MPI_INT64_T, root, handle_);
    text.resize(static_cast<std::size_t>(length));
    broadcast(std::as_writable_bytes(std::span(text.data(), text.size())), root);
}

std::vector<std::vector<std::byte>> Communicator::exchange_bytes(const std::vector<std::vector<std::byte>>& to) const {
    const auto n = static_cast<std::size_t>(size_);
    std::vector<std::int64_t> n_to(n), n_from(n);
    for (std::size_t r = 0; r < n; ++r) {
        n_to[r] = static_cast<std::int64_t>(to[r].size());
    }
    MPI_Alltoall(n_to.data(), 1, MPI_INT64_T, n_from.data(), 1, MPI_INT64_T, handle_);

    std::vector<std::vector<std::byte>> from(n);
    std::vector<MPI_Request> requests;
    for (std::size_t r = 0; r < n; ++r) {
        from[r].resize(static_cast<std::size_t>(n_from[r]));
        if (static_cast<int>(r) == rank_) {
            from[r] = to[r];
            continue;
        }
        for (std::size_t at = 0; at < from[r].size(); at += piece) {
            const auto count = static_cast<int>(std::min(piece, from[r].size() - at));
            MPI_Irecv(from[r].data() + at, count, MPI_BYTE, static_cast<int>(r), exchange_tag, handle_,
                      &requests.emplace_back());
        }
    }
    for (std::size_t r = 0; r < n; ++r) {
        if (static_cast<int>(r) == rank_) {
            continue;
        }
        for (std::size_t at = 0; at < to[r].size(); at += piece) {
            const auto count = static_cast<int>(std::min(piece, to[r].size() - at));
            MPI_Isend(to[r].data() + at, count, MPI_BYTE, static_cast<int>(r), exchange_tag, handle_,
                      &requests.emplace_back());
        }
    }
    MPI_Waitall(static_cast<int>(requests.size()), requests.data(), MPI_STATUSES_IGNORE);
    return from;
}

std::vector<std::byte> Communicator::all_gather_bytes(std::span<const std::byte> mine) const {
    std::vector<std::int64_t> lengths(static_cast<std::size_t>(size_));
    const auto length = static_cast<std::int64_t>(mine.size());
    MPI_Allgather(&length, 1, MPI_INT64_T, lengths.data(), 1, MPI_INT64_T, handle_);
    std::vector<std::byte> all;
    for (int r = 0; r < size_; ++r) {
        // One broadcast a rank: rare (set-up, rebalancing), and free of the int displacements of MPI_Allgatherv.
        const auto at = all.size();
        const auto n = static_cast<std::size_t>(lengths[static_cast<std::size_t>(r)]);
        if (n == 0) {
            continue;
        }
        all.resize(at + n);
        if (r == rank_) {
            std::copy(mine.begin(), mine.end(), all.begin() + static_cast<std::ptrdiff_t>(at));
        }
        broadcast(std::span(all).subspan(at, n), r);
    }
    return all;
}

std::string Communicator::first_error(const std::string& error) const {
    const std::int64_t none = std::numeric_limits<std::int64_t>::max();
    std::int64_t who = error.empty() ? none : rank_;
    MPI_Allreduce(MPI_IN_PLACE, &who, 1, MPI_INT64_T, MPI_MIN, handle_);
    if (who == none) {
        return {};
    }
    std::string text = error;
    broadcast(text, static_cast<int>(who));
    return text;
}

PendingMax::~PendingMax() {
    MPI_Wait(&request_, MPI_STATUS_IGNORE); // at once if none is under way
}

void PendingMax::start(const Communicator& comm, double value) {
    value_ = value;
    MPI_Iallreduce(MPI_IN_PLACE, &value_, 1, MPI_DOUBLE, MPI_MAX, comm.handle(), &request_);
}

double PendingMax::take() {
    MPI_Wait(&request_, MPI_STATUS_IGNORE);
    return value_;
}

} // namespace nappe
