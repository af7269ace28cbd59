// The scene reader: whatever the bytes are, parse_scene returns a scene that all may rely on, or throws an InputError
// that a user can act on.
//
// An input is the text of a scene; its comments "#set KEY=VALUE" are also taken for overrides.
#include "fuzz/fuzz_target.hpp"
#include "fuzz/message_rules.hpp"
#include "fuzz/scene_soundness.hpp"

#include "core/deposit.hpp"
#include "core/error.hpp"
#include "core/initial_grains.hpp"
#include "io/scene_keys.hpp"
#include "io/scene_reader.hpp"
#include "unit/scene_fields.hpp"

#include <algorithm>
#include <array>
#include <cstring>
#include <string_view>
#include <vector>

namespace {

using namespace nappe;
using fuzz::broken;

constexpr std::string_view file = "fuzz.toml";
constexpr std::string_view set_mark = "#set ";

std::vector<std::string> lines_of(std::string_view text) {
    std::vector<std::string> lines;
    for (std::size_t start = 0; start < text.size();) {
        const auto end = std::min(text.find('\n', start), text.size());
        lines.emplace_back(text.substr(start, end - start));
        start = end + 1;
    }
    return lines;
}

std::vector<std::string> overrides_of(std::string_view text) {
    std::vector<std::string> overrides;
    for (auto& line : lines_of(text)) {
        if (line.starts_with(set_mark)) {
            overrides.push_back(line.substr(set_mark.size()));
        }
    }
    return overrides;
}

/// The scene as run parses again to the same scene: what a restart and a measurement of stored frames rely on.
void check_round_trip(const Scene<2>& scene) {
    try {
        const auto again = parse_scene(scene.text, "scene.toml");
        if (test::fields(again) != test::fields(scene) || again.text != scene.text) {
            broken("the scene as run is the scene",
                   scene.text + "\n" + test::fields(scene) + "\n" + test::fields(again));
        }
    } catch (const InputError& error) {
        broken("the scene as run is accepted", scene.text + "\n" + error.what());
    }
}

/// A deposit of any accepted profile comes to an end, with grains or with words. Only small ones: time.
void check_deposit(const Scene<2>& scene) {
    if (!scene.sample || most_grains(*scene.sample) > 300) {
        return;
    }
    try {
        for (const auto& row : initial_grains(scene)) {
            if (!(row.mass > 0) || !std::isfinite(row.mass) || !std::isfinite(row.x[0]) || !std::isfinite(row.x[1])) {
                broken("grains have mass and place", std::to_string(row.id));
            }
        }
    } catch (const InputError& error) {
        if (const auto fault = fuzz::fault_of_text(error.what(), scene.text); !fault.empty()) {
            broken("a message says rule, value and remedy; this " + fault, error.what());
        }
    }
}

// What tempts a reader: the ends of ranges, numbers that are none, text of other kinds.
constexpr std::array<std::string_view, 44> values = {"0",
                                                     "-0.0",
                                                     "1",
                                                     "-1",
                                                     "0.5",
                                                     "1e-8",
                                                     "1e-300",
                                                     "4.9e-324",
                                                     "1e300",
                                                     "1e18",
                                                     "-1e308",
                                                     "nan",
                                                     "inf",
                                                     "-inf",
                                                     "2147483647",
                                                     "2147483648",
                                                     "9223372036854775807",
                                                     "-9223372036854775808",
                                                     "9007199254740993",
                                                     "0x7fffffff",
                                                     "0b1",
                                                     "true",
                                                     "\"\"",
                                                     "\"rock\"",
                                                     "\"wall\"",
                                                     "\"a\\nb\"",
                                                     "\"\\u0000\"",
                                                     "\"ü…\"",
                                                     "'''\n'''",
                                                     "[]",
                                                     "[[]]",
                                                     "[0, 0]",
                                                     "[[0, 0], [1, 0], [0, 1]]",
                                                     "[1e300, -1e300]",
                                                     "[nan, 1]",
                                                     "{}",
                                                     "{ every = 1 }",
                                                     "{ a.b.c = 1 }",
                                                     "1979-05-27",
                                                     "07:32:00",
                                                     "{ stage = \"push\" }",
                                                     "[{}]",
                                                     "[1, \"a\"]",
                                                     "3.0"};

std::string any_key(fuzz::Draws& draws) {
    const auto& table = draws.any(scene_file::all_keys());
    return std::string(draws.any(table.keys));
}

/// One edit of one line, of a kind that blind changes of bytes seldom find.
void edit(std::vector<std::string>& lines, fuzz::Draws& draws) {
    const auto at = draws.below(lines.size() + 1);
    const auto place = lines.begin() + static_cast<std::ptrdiff_t>(at);
    const auto assignment = [&](const std::string& key) { return key + " = " + std::string(draws.any(values)); };
    switch (draws.below(7)) {
    case 0:
        lines.insert(place, assignment(any_key(draws)));
        return;
    case 1:
        lines.push_back(std::string(set_mark) + any_key(draws) + "." + any_key(draws) + "=" +
                        std::string(draws.any(values)));
        return;
    case 2:
        lines.insert(place, draws.one_in(2) ? "[" + any_key(draws) + "]" : "[[" + any_key(draws) + "]]");
        return;
    default:
        break;
    }
    if (at == lines.size()) {
        return;
    }
    std::string& line = lines[at];
    if (const auto equals = line.find('='); draws.one_in(2) && equals != std::string::npos) {
        line = assignment(line.substr(0, equals));
    } else if (const auto digit = line.find_first_of("0123456789", draws.below(line.size() + 1));
               digit != std::string::npos) {
        const auto end = line.find_first_not_of("0123456789.e-", digit);
        line.replace(digit, std::min(end, line.size()) - digit, draws.any(values));
    } else if (draws.one_in(2)) {
        lines.erase(place);
    } else {
        lines.insert(place, std::string(draws.any(lines)));
    }
}

} // namespace

int LLVMFuzzerInitialize(int*, char***) {
    return 0;
}

int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
    const std::string text(reinterpret_cast<const char*>(data), size);
    try {
        const auto scene = parse_scene(text, file, overrides_of(text));
        if (const auto fault = fuzz::fault_of_scene(scene); !fault.empty()) {
            broken(fault, test::fields(scene));
        }
        check_round_trip(scene);
        check_deposit(scene);
    } catch (const InputError& error) {
        if (const auto fault = fuzz::fault_of_scene_message(error.what(), file, text); !fault.empty()) {
            broken("a message says place, rule, value and remedy; this " + fault, error.what());
        }
    }
    return 0;
}

std::size_t LLVMFuzzerCustomMutator(std::uint8_t* data, std::size_t size, std::size_t max_size, unsigned seed) {
    fuzz::Draws draws(seed);
    if (draws.one_in(3)) {
        return LLVMFuzzerMutate(data, size, max_size);
    }
    auto lines = lines_of({reinterpret_cast<const char*>(data), size});
    for (std::size_t k = draws.below(3) + 1; k > 0; --k) {
        edit(lines, draws);
    }
    std::string text;
    for (const auto& line : lines) {
        text += line + "\n";
    }
    const auto kept = std::min(text.size(), max_size);
    std::memcpy(data, text.data(), kept);
    return kept;
}
