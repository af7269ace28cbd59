#pragma once
// Rows in the order of their GlobalId, a contiguous block of ids a rank: the order of every file, so that what is
// written does not depend on who owned what.

#include "core/error.hpp"
#include "core/types.hpp"
#include "parallel/communicator.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <string>
#include <utility>
#include <vector>

namespace nappe {

/// Ids 0 … n-1 cut into one block a rank, as even as can be. Local.
struct IdBlocks {
    std::int64_t n = 0;
    std::int64_t n_ranks = 1;

    std::int64_t first(int rank) const { return n * rank / n_ranks; }
    std::int64_t count(int rank) const { return first(rank + 1) - first(rank); }
    /// Who holds an id in [0, n): the largest rank with first(rank) <= id.
    int holder(GlobalId id) const { return static_cast<int>(((id + 1) * n_ranks - 1) / n); }
};

/// Rows [first, first + rows) of a table of `total` rows are this rank's.
struct RowRange {
    std::int64_t first = 0;
    std::int64_t rows = 0;
    std::int64_t total = 0;
};

/// The range of each rank when ranks hold their rows one after the other. Collective over comm.
inline RowRange row_range(const Communicator& comm, std::size_t n_mine) {
    RowRange range{0, static_cast<std::int64_t>(n_mine), 0};
    const auto counts = comm.all_gather(std::vector<std::int64_t>{range.rows});
    for (int r = 0; r < comm.size(); ++r) {
        const auto count = counts[static_cast<std::size_t>(r)];
        range.first += r < comm.rank() ? count : 0;
        range.total += count;
    }
    return range;
}

/// Rows that rank 0 writes for all.
inline RowRange by_root(const Communicator& comm, std::size_t n) {
    const auto total = static_cast<std::int64_t>(n);
    return {comm.is_root() ? 0 : total, comm.is_root() ? total : 0, total};
}

/// Sends each row to the rank whose block holds id_of(row). Collective over comm. A row outside 0 … n-1 is a bug of the
/// caller: SystemError on all ranks.
template <class Row, class IdOf>
std::vector<Row> send_to_blocks(const Communicator& comm, const IdBlocks& blocks, std::vector<Row>&& rows, IdOf id_of) {
    std::vector<std::vector<Row>> to(static_cast<std::size_t>(comm.size()));
    std::string error;
    for (const Row& row : rows) {
        const GlobalId id = id_of(row);
        if (id < 0 || id >= blocks.n) {
            error =
                fmt::format("grain id {} is outside 0 … {} on rank {}: a bug of nappe", id, blocks.n - 1, comm.rank());
            continue;
        }
        to[static_cast<std::size_t>(blocks.holder(id))].push_back(row);
    }
    std::vector<Row>().swap(rows);
    comm.throw_together<SystemError>(error);
    std::vector<Row> mine;
    for (auto& part : comm.exchange(to)) {
        mine.insert(mine.end(), part.begin(), part.end());
    }
    return mine;
}

/// Grains sorted by id on the rank of their block, each id there once. Collective over comm. id_of(row) is the
/// GlobalId. SystemError on all ranks if one is missing or there twice: nothing incomplete is ever stored.
template <class Row, class IdOf>
std::vector<Row> grains_in_blocks(const Communicator& comm, const IdBlocks& blocks, std::vector<Row>&& rows,
                                  IdOf id_of) {
    auto mine = send_to_blocks(comm, blocks, std::move(rows), id_of);
    std::sort(mine.begin(), mine.end(), [&](const Row& a, const Row& b) { return id_of(a) < id_of(b); });
    // The total is n, so an id that is missing somewhere is there twice, or another is.
    std::string error;
    const GlobalId first = blocks.first(comm.rank());
    for (std::size_t i = 0; i < mine.size() && error.empty(); ++i) {
        if (const GlobalId expected = first + static_cast<GlobalId>(i); id_of(mine[i]) != expected) {
            error = fmt::format("grain {} is {} among all ranks' rows: a bug of nappe",
                                std::min(id_of(mine[i]), expected), id_of(mine[i]) < expected ? "twice" : "missing");
        }
    }
    comm.throw_together<SystemError>(error);
    return mine;
}

/// Contacts sorted by (lo, hi) on the rank of lo's block. Collective over comm. SystemError on all ranks if a pair is
/// there twice.
template <class Row>
std::vector<Row> contacts_in_blocks(const Communicator& comm, const IdBlocks& blocks, std::vector<Row>&& rows) {
    auto mine = send_to_blocks(comm, blocks, std::move(rows), [](const Row& row) { return row.lo; });
    const auto key = [](const Row& row) { return std::pair(row.lo, row.hi); };
    std::sort(mine.begin(), mine.end(), [&](const Row& a, const Row& b) { return key(a) < key(b); });
    const auto twice =
        std::adjacent_find(mine.begin(), mine.end(), [&](const Row& a, const Row& b) { return key(a) == key(b); });
    comm.throw_together<SystemError>(
        twice == mine.end() ? std::string()
                            : fmt::format("contact ({}, {}) is there twice among all ranks' rows: a bug of nappe",
                                          twice->lo, twice->hi));
    return mine;
}

} // namespace nappe
