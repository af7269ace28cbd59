#pragma once
// Every key that a scene file may hold, table by table. The reader refuses all others, and a test holds docs/scene.md
// against this list. Internal to src/io and its tests.

#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace nappe::scene_file {

struct TableKeys {
    std::string_view table; ///< as docs/scene.md heads it: "[solver]", "walls.motion"; "top level" for the file itself
    std::vector<std::string_view> keys;
};

/// All tables, in the order of docs/scene.md. Local.
const std::vector<TableKeys>& all_keys();

/// All tables of a matrix of settings (io/trade_matrix.hpp), in the order of docs/accuracy.md. Local.
const std::vector<TableKeys>& matrix_keys();

/// The table of that name, of a scene or of a matrix, which must exist. Local.
const TableKeys& keys_of(std::string_view table);

/// The candidate that `word` is most likely a misspelling of, if any is close. Local.
std::optional<std::string> nearest(std::string_view word, const std::vector<std::string>& candidates);

/// "a, b, c"; the first 20 of them. Local.
std::string listed(const std::vector<std::string>& words);

} // namespace nappe::scene_file
