#pragma once
// One TOML table of a scene, read key by key. Every access checks type and range; whatever is wrong is collected, so that
// one run of `nappe check` shows all independent errors. Internal to src/io.

#include "core/types.hpp"

#include <toml++/toml.h>

#include <cstdint>
#include <limits>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

namespace nappe::scene_file {

/// The file's tree. Local. Throws InputError, with the line, if it is not TOML, or nested deeper than any scene (trees
/// are taken down by recursion: the stack must hold it).
toml::table parse_toml(std::string_view text, std::string_view file_name);

/// What is wrong with a scene: place, key, rule, value found, remedy. Every member is Local.
class Problems {
public:
    /// Both must outlive the object.
    Problems(const toml::table& root, std::string_view file) : root_(root), file_(file) {}

    /// At the key, or where its closest existing parent starts. `text` holds rule, value found and remedy.
    void add(const std::string& path, const std::string& text);
    /// At a node; `path` is shown only.
    void add_at(const toml::node& node, const std::string& path, const std::string& text);

    /// "FILE:LINE: PATH" of a node, or where else it comes from.
    std::string place_of(const toml::node& node, const std::string& path) const;

    bool empty() const { return problems_.empty(); }
    /// Throws InputError with one problem a line, in the order of the file.
    void throw_if_any() const;

private:
    void keep(unsigned line, std::string text);
    unsigned line_of(const toml::node& node) const;

    struct Problem {
        unsigned line = 0;
        std::string text;
    };
    const toml::table& root_;
    std::string_view file_;
    std::vector<Problem> problems_; ///< no more than anyone reads
    std::size_t more_ = 0;          ///< left out
};

inline constexpr double no_limit = std::numeric_limits<double>::infinity();

/// No number of a scene is larger, and none that must be > 0 in some unit is smaller than its inverse: products and squares
/// of a few of them (masses, energies) are numbers still.
inline constexpr double largest_number = 1e30;
inline constexpr double smallest_measure = 1e-30;

/// The values that a real number may take. Never infinite, never NaN.
struct RealRule {
    double min = -no_limit;
    double max = no_limit;
    bool above_min = false; ///< min itself is excluded
    std::string_view unit;  ///< "m"; "" for a pure number
    std::string_view remedy;
};
/// > 0
constexpr RealRule positive(std::string_view unit, std::string_view remedy) {
    return {0, no_limit, true, unit, remedy};
}
/// >= 0
constexpr RealRule not_negative(std::string_view unit, std::string_view remedy) {
    return {0, no_limit, false, unit, remedy};
}
constexpr RealRule between(double min, double max, std::string_view unit, std::string_view remedy) {
    return {min, max, false, unit, remedy};
}
constexpr RealRule any_real(std::string_view unit, std::string_view remedy) {
    return {-no_limit, no_limit, false, unit, remedy};
}

/// Sums of a few of them are ints still.
inline constexpr std::int64_t largest_count = 500'000'000;

struct IntegerRule {
    std::int64_t min = 0;
    std::string_view remedy;
    std::int64_t max = largest_count;
};

enum class Need { optional, required };

/// Things of one kind that a scene may name: rules compare all pairs of them.
inline constexpr std::size_t most_named = 1000;

/// Reads the keys of one table. `read` assigns its target and returns true if the key is there and good; a wrong value,
/// or a required key that is absent, is added to the problems and the target is left alone. Every member is Local.
class TableReader {
public:
    /// Reports every key of the table that `keys_of(known_as)` does not list. `path` is "" for the file itself.
    TableReader(const toml::table& table, std::string path, std::string_view known_as, Problems& problems);

    bool read(std::string_view key, double& target, const RealRule& rule, Need need = Need::optional) const;
    bool read(std::string_view key, std::optional<double>& target, const RealRule& rule) const;
    bool read(std::string_view key, int& target, const IntegerRule& rule, Need need = Need::optional) const;
    bool read(std::string_view key, std::int64_t& target, const IntegerRule& rule, Need need = Need::optional) const;
    bool read(std::string_view key, std::string& target, std::string_view remedy, Need need = Need::optional) const;
    bool read(std::string_view key, bool& target, std::string_view remedy) const;
    bool read(std::string_view key, Vec<2>& target, const RealRule& rule, Need need = Need::optional) const;
    bool read(std::string_view key, std::vector<double>& target, const RealRule& rule) const;
    bool read(std::string_view key, std::vector<Vec<2>>& target, const RealRule& rule, Need need) const;

    /// A table below this one; none if absent or not a table.
    std::optional<TableReader> table(std::string_view key, std::string_view known_as, std::string_view remedy,
                                     Need need = Need::optional) const;
    /// An array of tables below this one; empty if absent, of another type, or longer than `most`.
    std::vector<TableReader> tables(std::string_view key, std::string_view known_as, std::string_view remedy,
                                    std::size_t most = most_named) const;
    /// [key.NAME]: tables below this one whose keys are free names; none if there are more than `most`.
    std::vector<std::pair<std::string, TableReader>> named_tables(std::string_view key, std::string_view known_as,
                                                                  std::string_view remedy, std::size_t most) const;

    bool has(std::string_view key) const { return find(key) != nullptr; }
    const toml::node* find(std::string_view key) const { return table_->get(key); }
    const std::string& path() const { return path_; }
    /// "KEY: RULE, found VALUE; REMEDY" at the key (may be dotted, as in between.1), or "found nothing" at the table.
    void problem(std::string_view key, std::string_view rule, std::string_view remedy) const;
    /// Where the key is, or its table if it is absent: "FILE:LINE: PATH".
    std::string place_of(std::string_view key) const;

private:
    bool absent(std::string_view key, std::string_view rule, std::string_view remedy, Need need) const;
    bool check_real(const toml::node& node, const std::string& path, double& target, const RealRule& rule) const;
    bool check_vector(const toml::node& node, const std::string& path, Vec<2>& target, const RealRule& rule) const;

    const toml::table* table_;
    std::string path_;
    Problems* problems_;
};

} // namespace nappe::scene_file
