#pragma once
// `nappe info FILE`: what a file that nappe wrote holds, and whether it is sound; of a folder, where its run stands.

#include "core/error.hpp"
#include "parallel/communicator.hpp"

#include <filesystem>

namespace nappe {

/// **Collective.** The root looks and prints. Throws InputError on all ranks if it is no file of nappe's, or a damaged one:
/// then all that could be found out is printed before.
ExitCode info(const Communicator& comm, const std::filesystem::path& path);

} // namespace nappe
