#pragma once
// The ranks of a run. No other folder names MPI (src/io takes the handle for parallel HDF5); nothing assumes
// MPI_COMM_WORLD.

#include <mpi.h>

#include <cstddef>
#include <cstdint>
#include <cstring>
#include <span>
#include <string>
#include <type_traits>
#include <vector>

namespace nappe {

/// Owns MPI from its first line to its last; one per process, made in main.
class MpiSession {
public:
    MpiSession(int& argc, char**& argv);
    ~MpiSession();
    MpiSession(const MpiSession&) = delete;
    MpiSession& operator=(const MpiSession&) = delete;
};

/// Local. Name and version of the MPI library, its first line.
std::string mpi_library();

/// A duplicate of an MPI communicator, freed with its owner. Every member is **collective** unless it says Local.
class Communicator {
public:
    /// Duplicates `parent`; all ranks of the job by default, MPI_COMM_SELF in serial tests.
    explicit Communicator(MPI_Comm parent = MPI_COMM_WORLD);
    ~Communicator();
    /// Local. This rank by itself, as if the job had no other.
    static Communicator alone() { return Communicator(MPI_COMM_SELF); }
    Communicator(Communicator&& other) noexcept;
    Communicator(const Communicator&) = delete;
    Communicator& operator=(const Communicator&) = delete;
    Communicator& operator=(Communicator&&) = delete;

    int rank() const { return rank_; }          ///< Local.
    int size() const { return size_; }          ///< Local.
    bool is_root() const { return rank_ == 0; } ///< Local.
    MPI_Comm handle() const { return handle_; } ///< Local; for parallel HDF5 only.

    /// Local. Ends the whole job: for an error on one rank that the others can not know of.
    [[noreturn]] void abort(int code) const;

    void barrier() const;
    /// A barrier whose early ranks sleep, so that the others have the machine to themselves; about a millisecond slow.
    void sleepy_barrier() const;
    std::int64_t sum(std::int64_t value) const;
    std::uint64_t sum_wrapping(std::uint64_t value) const; ///< modulo 2^64
    void sum(std::span<std::int64_t> values) const;        ///< in place, element by element
    double max(double value) const;                        ///< of numbers: NaN must have been flagged before
    std::int64_t max(std::int64_t value) const;
    void max(std::span<double> values) const; ///< in place, element by element; of numbers
    std::uint32_t bit_or(std::uint32_t flags) const;
    void broadcast(std::span<std::byte> bytes, int root = 0) const;
    void broadcast(std::string& text, int root = 0) const;

    /// One message of any length to each rank, one from each; [r] to and from rank r. Order of arrival has no
    /// influence.
    std::vector<std::vector<std::byte>> exchange_bytes(const std::vector<std::vector<std::byte>>& to) const;

    /// exchange_bytes for arrays of trivially copyable records.
    template <class T>
    std::vector<std::vector<T>> exchange(const std::vector<std::vector<T>>& to) const {
        static_assert(std::is_trivially_copyable_v<T>);
        std::vector<std::vector<std::byte>> out(to.size());
        for (std::size_t r = 0; r < to.size(); ++r) {
            out[r].resize(to[r].size() * sizeof(T));
            if (!to[r].empty()) {
                std::memcpy(out[r].data(), to[r].data(), out[r].size());
            }
        }
        const auto in = exchange_bytes(out);
        std::vector<std::vector<T>> from(in.size());
        for (std::size_t r = 0; r < in.size(); ++r) {
            from[r].resize(in[r].size() / sizeof(T));
            if (!in[r].empty()) {
                std::memcpy(from[r].data(), in[r].data(), in[r].size());
            }
        }
        return from;
    }

    /// Every rank's records on every rank, in the order of ranks.
    template <class T>
    std::vector<T> all_gather(const std::vector<T>& mine) const {
        static_assert(std::is_trivially_copyable_v<T>);
        const auto bytes = all_gather_bytes(std::as_bytes(std::span(mine)));
        std::vector<T> all(bytes.size() / sizeof(T));
        if (!bytes.empty()) {
            std::memcpy(all.data(), bytes.data(), bytes.size());
        }
        return all;
    }

    /// Throws on every rank alike if `error` is not empty on any: the text of the lowest rank that has one. E is one of
    /// core/error.hpp.
    template <class E>
    void throw_together(const std::string& error) const {
        const std::string text = first_error(error);
        if (!text.empty()) {
            throw E(text);
        }
    }

    /// A text that ranks agree on: that of the lowest rank whose text is not empty; empty if all are.
    std::string first_error(const std::string& error) const;

private:
    std::vector<std::byte> all_gather_bytes(std::span<const std::byte> mine) const;

    MPI_Comm handle_ = MPI_COMM_NULL;
    int rank_ = 0;
    int size_ = 1;
};

/// A maximum over ranks that is formed while they do other things. All ranks start and take theirs in the same order.
class PendingMax {
public:
    PendingMax() = default;
    ~PendingMax();
    PendingMax(const PendingMax&) = delete;
    PendingMax& operator=(const PendingMax&) = delete;

    /// **Collective**, does not wait. Pre: none is under way. @param value a number: NaN must have been flagged before
    void start(const Communicator& comm, double value);

    /// **Collective**, waits. The largest of the values. Pre: started.
    double take();

private:
    double value_ = 0; // MPI writes here until taken
    MPI_Request request_ = MPI_REQUEST_NULL;
};

} // namespace nappe
