#include "io/scene_table.hpp"

#include "core/error.hpp"
#include "io/scene_keys.hpp"
#include "io/scene_path.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

namespace nappe::scene_file {

namespace {

/// "must be > 0 [m]"
std::string words(const RealRule& rule) {
    std::string text = "must be a finite number";
    if (rule.max < no_limit) {
        text = fmt::format("must lie in {}{}, {}]", rule.above_min ? "(" : "[", rule.min, rule.max);
    } else if (rule.min > -no_limit) {
        text = fmt::format("must be {} {}", rule.above_min ? ">" : ">=", rule.min);
    }
    return rule.unit.empty() ? text : fmt::format("{} [{}]", text, rule.unit);
}

/// The bound on all counts is told only to those who pass it.
std::string words(const IntegerRule& rule, std::int64_t found = 0) {
    if (rule.min == rule.max) {
        return fmt::format("must be {}", rule.min);
    }
    return rule.max < largest_count || found > rule.max
               ? fmt::format("must be an integer in [{}, {}]", rule.min, rule.max)
               : fmt::format("must be an integer >= {}", rule.min);
}

bool holds(const RealRule& rule, double value) {
    return std::isfinite(value) && value >= rule.min && value <= rule.max && !(rule.above_min && value == rule.min);
}

/// What a value that is good in itself breaks nevertheless: it makes no sense and would overflow. "" if nothing.
std::string excess(const RealRule& rule, double value) {
    const auto unit = rule.unit.empty() ? "" : fmt::format(" [{}]", rule.unit);
    if (std::abs(value) > largest_number) {
        return fmt::format("must lie within ±{}{}", largest_number, unit);
    }
    const bool measure = rule.above_min && rule.min == 0 && !rule.unit.empty();
    return measure && value < smallest_measure ? fmt::format("must be >= {}{}", smallest_measure, unit) : "";
}

std::string message(std::string_view rule, std::string_view found, std::string_view remedy) {
    return fmt::format("{}, found {}{}{}", rule, found, remedy.empty() ? "" : "; ", remedy);
}

/// toml++ bounds brackets in brackets, but not the parts of a dotted key. Dots between two characters that end a key are
/// counted, those of texts too: a line of prose with more is not to be expected.
void check_depth(std::string_view text, std::string_view file_name) {
    constexpr int most = 32;
    std::size_t line = 1;
    int dots = 0;
    for (const char c : text) {
        line += c == '\n' ? 1 : 0;
        if (c == '.') {
            ++dots;
        } else if (std::string_view("=,[]{}#\n").find(c) != std::string_view::npos) {
            dots = 0;
        }
        if (dots > most) {
            throw InputError(fmt::format("{}:{}: must have at most {} dots in a key, found more; keys of scenes have "
                                         "few (or break up the text)",
                                         file_name, line, most));
        }
    }
}

} // namespace

toml::table parse_toml(std::string_view text, std::string_view file_name) {
    check_depth(text, file_name);
    try {
        return toml::parse(text, file_name);
    } catch (const toml::parse_error& error) {
        throw InputError(fmt::format("{}:{}: must be valid TOML, found: {} (column {}); see https://toml.io", file_name,
                                     error.source().begin.line, one_line(error.description(), 300),
                                     error.source().begin.column));
    }
}

void Problems::add(const std::string& path, const std::string& text) {
    const toml::node* node = &root_;
    for (const auto& segment : split_path(path)) {
        const toml::node* child = find_child(*node, segment);
        if (child == nullptr || child->source().begin.line == 0) {
            break;
        }
        node = child;
    }
    add_at(*node, path, text);
}

void Problems::add_at(const toml::node& node, const std::string& path, const std::string& text) {
    keep(line_of(node), fmt::format("{}: {}", place_of(node, path), text));
}

/// 0: none worth telling, as of a value that came by --set, which has the override for its "file".
unsigned Problems::line_of(const toml::node& node) const {
    const auto& source = node.source();
    return (source.path && *source.path != file_) || &node == &root_ ? 0 : source.begin.line;
}

std::string Problems::place_of(const toml::node& node, const std::string& path) const {
    const auto& source = node.source();
    if (source.path && *source.path != file_) {
        return fmt::format("{}: {}", *source.path, path);
    }
    const auto line = line_of(node);
    return line == 0 ? fmt::format("{}: {}", file_, path) : fmt::format("{}:{}: {}", file_, line, path);
}

void Problems::keep(unsigned line, std::string text) {
    constexpr std::size_t most = 1000;
    if (problems_.size() < most) {
        problems_.push_back({line, std::move(text)});
    } else {
        ++more_;
    }
}

void Problems::throw_if_any() const {
    if (problems_.empty()) {
        return;
    }
    auto sorted = problems_;
    std::stable_sort(sorted.begin(), sorted.end(), [](const auto& a, const auto& b) { return a.line < b.line; });
    constexpr std::size_t most = 20;
    std::string text;
    for (std::size_t i = 0; i < std::min(most, sorted.size()); ++i) {
        text += (i > 0 ? "\n" : "") + sorted[i].text;
    }
    if (sorted.size() > most) {
        text += fmt::format("\n… and {} more", sorted.size() - most + more_);
    }
    throw InputError(text);
}

TableReader::TableReader(const toml::table& table, std::string path, std::string_view known_as, Problems& problems)
    : table_(&table), path_(std::move(path)), problems_(&problems) {
    const auto& views = keys_of(known_as).keys;
    const std::vector<std::string> known(views.begin(), views.end());
    for (const auto& [key, node] : table) {
        const std::string name(key.str());
        if (std::find(known.begin(), known.end(), name) == known.end()) {
            const auto meant = nearest(name, known);
            problems_->add_at(node, join_path(path_, one_line(name)),
                              fmt::format("unknown key; must be one of those of {} ({}), found \"{}\"; {}",
                                          known_as == "top level" || known_as == "matrix" ? "the top level" : known_as,
                                          listed(known), one_line(name),
                                          meant ? fmt::format("did you mean {}?", *meant) : "remove it"));
        }
    }
}

bool TableReader::absent(std::string_view key, std::string_view rule, std::string_view remedy, Need need) const {
    if (has(key)) {
        return false;
    }
    if (need == Need::required) {
        problem(key, fmt::format("is required and {}", rule), remedy);
    }
    return true;
}

void TableReader::problem(std::string_view key, std::string_view rule, std::string_view remedy) const {
    const toml::node* node = table_;
    for (const auto& segment : split_path(key)) {
        node = node != nullptr ? find_child(*node, segment) : nullptr;
    }
    const auto text = message(rule, node != nullptr ? shown(*node) : "nothing", remedy);
    // At the table itself if the key is absent: a path would find a namesake where names are not unique.
    problems_->add_at(node != nullptr ? *node : *table_, join_path(path_, key), text);
}

std::string TableReader::place_of(std::string_view key) const {
    const toml::node* node = find(key);
    return problems_->place_of(node != nullptr ? *node : *table_, join_path(path_, key));
}

bool TableReader::check_real(const toml::node& node, const std::string& path, double& target,
                             const RealRule& rule) const {
    const auto* integer = node.as_integer();
    const auto value = integer != nullptr ? static_cast<double>(integer->get()) : node.value_exact<double>();
    std::string broken;
    if (!value || !holds(rule, *value)) {
        broken = value ? words(rule) : fmt::format("{} (a number)", words(rule));
    } else {
        broken = excess(rule, *value);
    }
    if (!broken.empty()) {
        problems_->add_at(node, path, message(broken, shown(node), rule.remedy));
        return false;
    }
    target = *value;
    return true;
}

bool TableReader::check_vector(const toml::node& node, const std::string& path, Vec<2>& target,
                               const RealRule& rule) const {
    const auto* array = node.as_array();
    if (array == nullptr || array->size() != 2) {
        const auto unit = rule.unit.empty() ? "" : fmt::format(" [{}]", rule.unit);
        problems_->add_at(node, path,
                          message(fmt::format("must be two numbers [x, y]{}", unit), shown(node), rule.remedy));
        return false;
    }
    Vec<2> value = Vec<2>::Zero();
    const bool x = check_real(*array->get(0), join_path(path, "0"), value[0], rule);
    const bool y = check_real(*array->get(1), join_path(path, "1"), value[1], rule);
    if (x && y) {
        target = value;
    }
    return x && y;
}

bool TableReader::read(std::string_view key, double& target, const RealRule& rule, Need need) const {
    return !absent(key, words(rule), rule.remedy, need) && check_real(*find(key), join_path(path_, key), target, rule);
}

bool TableReader::read(std::string_view key, std::optional<double>& target, const RealRule& rule) const {
    double value = 0;
    const bool good = read(key, value, rule);
    if (good) {
        target = value;
    }
    return good;
}

bool TableReader::read(std::string_view key, std::int64_t& target, const IntegerRule& rule, Need need) const {
    if (absent(key, words(rule), rule.remedy, need)) {
        return false;
    }
    const auto* value = find(key)->as_integer();
    if (value == nullptr || value->get() < rule.min || value->get() > rule.max) {
        problem(key, value != nullptr ? words(rule, value->get()) : words(rule), rule.remedy);
        return false;
    }
    target = value->get();
    return true;
}

bool TableReader::read(std::string_view key, int& target, const IntegerRule& rule, Need need) const {
    std::int64_t value = 0;
    const bool good = read(key, value, rule, need);
    if (good) {
        target = static_cast<int>(value);
    }
    return good;
}

bool TableReader::read(std::string_view key, bool& target, std::string_view remedy) const {
    if (!has(key)) {
        return false;
    }
    const auto* value = find(key)->as_boolean();
    if (value == nullptr) {
        problem(key, "must be true or false", remedy);
        return false;
    }
    target = value->get();
    return true;
}

bool TableReader::read(std::string_view key, std::string& target, std::string_view remedy, Need need) const {
    if (absent(key, "must be a string", remedy, need)) {
        return false;
    }
    const auto* value = find(key)->as_string();
    if (value == nullptr) {
        problem(key, "must be a string", remedy);
        return false;
    }
    target = value->get();
    return true;
}

bool TableReader::read(std::string_view key, Vec<2>& target, const RealRule& rule, Need need) const {
    return !absent(key, "must be two numbers [x, y]", rule.remedy, need) &&
           check_vector(*find(key), join_path(path_, key), target, rule);
}

bool TableReader::read(std::string_view key, std::vector<double>& target, const RealRule& rule) const {
    const auto* array = has(key) ? find(key)->as_array() : nullptr;
    if (array == nullptr) {
        return false;
    }
    std::vector<double> values(array->size());
    bool good = true;
    for (std::size_t i = 0; i < values.size(); ++i) {
        const auto path = join_path(join_path(path_, key), std::to_string(i));
        good = check_real(*array->get(i), path, values[i], rule) && good;
    }
    if (good) {
        target = std::move(values);
    }
    return good;
}

bool TableReader::read(std::string_view key, std::vector<Vec<2>>& target, const RealRule& rule, Need need) const {
    constexpr auto kind = "must be an array of points [[x, y], …]";
    if (absent(key, kind, rule.remedy, need)) {
        return false;
    }
    const auto* array = find(key)->as_array();
    if (array == nullptr) {
        problem(key, kind, rule.remedy);
        return false;
    }
    std::vector<Vec<2>> points(array->size());
    bool good = true;
    for (std::size_t i = 0; i < points.size(); ++i) {
        const auto path = join_path(join_path(path_, key), std::to_string(i));
        good = check_vector(*array->get(i), path, points[i], rule) && good;
    }
    if (good) {
        target = std::move(points);
    }
    return good;
}

std::optional<TableReader> TableReader::table(std::string_view key, std::string_view known_as, std::string_view remedy,
                                              Need need) const {
    if (absent(key, "must be a table", remedy, need)) {
        return std::nullopt;
    }
    const auto* below = find(key)->as_table();
    if (below == nullptr) {
        problem(key, "must be a table", remedy);
        return std::nullopt;
    }
    return TableReader(*below, join_path(path_, key), known_as, *problems_);
}

std::vector<TableReader> TableReader::tables(std::string_view key, std::string_view known_as, std::string_view remedy,
                                             std::size_t most) const {
    std::vector<TableReader> readers;
    if (!has(key)) {
        return readers;
    }
    const auto* array = find(key)->as_array();
    if (array == nullptr) {
        problem(key, "must be an array of tables", remedy);
        return readers;
    }
    if (array->size() > most) {
        problem(key, fmt::format("must hold at most {} tables", most), "merge some, or split the scene");
        return readers;
    }
    const auto labels = element_labels(*array);
    for (std::size_t i = 0; i < array->size(); ++i) {
        const auto path = join_path(join_path(path_, key), labels[i]);
        if (const auto* below = array->get(i)->as_table()) {
            readers.emplace_back(*below, path, known_as, *problems_);
        } else {
            problems_->add_at(*array->get(i), path, message("must be a table", shown(*array->get(i)), remedy));
        }
    }
    return readers;
}

std::vector<std::pair<std::string, TableReader>> TableReader::named_tables(std::string_view key,
                                                                           std::string_view known_as,
                                                                           std::string_view remedy,
                                                                           std::size_t most) const {
    std::vector<std::pair<std::string, TableReader>> readers;
    const auto* parent = has(key) ? find(key)->as_table() : nullptr;
    if (parent == nullptr) {
        if (has(key)) {
            problem(key, "must hold tables", remedy);
        }
        return readers;
    }
    if (parent->size() > most) {
        problem(key, fmt::format("must hold at most {} tables", most), "merge some, or split the scene");
        return readers;
    }
    for (const auto& [name, node] : *parent) {
        const auto path = join_path(join_path(path_, key), one_line(name.str()));
        if (!is_name(name.str())) {
            problems_->add_at(node, path,
                              message("must be named with 1 to 64 letters, digits, _ or -",
                                      fmt::format("\"{}\"", one_line(name.str())), "rename it"));
        } else if (const auto* below = node.as_table()) {
            readers.emplace_back(std::string(name.str()), TableReader(*below, path, known_as, *problems_));
        } else {
            problems_->add_at(node, path, message("must be a table", shown(node), remedy));
        }
    }
    return readers;
}

} // namespace nappe::scene_file
