#pragma once
// Files that a user names may be of any length, and some (/dev/zero) never end.

#include <array>
#include <cstddef>
#include <istream>
#include <string>

namespace nappe {

/// What the stream holds, but no more than `most` + 1 bytes: whoever gets more than `most` refuses the file. Local.
inline std::string read_at_most(std::istream& in, std::size_t most) {
    std::string text;
    for (std::array<char, 1 << 14> piece; in && text.size() <= most;) {
        in.read(piece.data(), piece.size());
        text.append(piece.data(), static_cast<std::size_t>(in.gcount()));
    }
    return text.size() > most ? text.substr(0, most + 1) : text;
}

} // namespace nappe
