#pragma once
// The matrix of settings that `nappe trade` runs: TOML in, every rule checked. docs/accuracy.md documents the keys.

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace nappe {

/// A key of the scene with its new value.
struct TradeKey {
    std::string key;   ///< of a solver table: "h"; of `set`: a path into the scene, "output.front_bin"
    std::string value; ///< TOML, on one line
    std::string place; ///< "FILE:LINE: SETTING", for messages
};

/// One way to compute the scene.
struct TradeSetting {
    std::string name; ///< fit for a folder; "reference" is the reference's alone
    std::string place;
    std::vector<TradeKey> solver; ///< over the [solver] keys of each stage with a duration
    std::vector<TradeKey> set;    ///< over the scene
};

struct TradeMatrix {
    std::string text;                ///< as read
    std::vector<std::int64_t> seeds; ///< of the sample; empty: the scene's own
    double window = 0.2;             ///< share of loading, at its end, over which observables are averaged
    std::optional<double> duration;  ///< of loading at most [s]
    std::optional<int> frames;       ///< after the first; none: as often as the scene says
    TradeSetting reference;
    std::vector<TradeSetting> settings; ///< at least one
};

/// The text of a matrix file. Local. Throws InputError.
std::string read_matrix_text(const std::string& path);

/// The matrix that `text` describes. Whether a scene knows the keys of its settings, and takes their values, is for the
/// scene reader to say. Local. Throws InputError with one line per problem: FILE:LINE: KEY: rule, value found; remedy.
TradeMatrix parse_matrix(std::string_view text, std::string_view file_name);

} // namespace nappe
