#pragma once

// What a program installs for people at a shell.

#include <filesystem>
#include <string>

#include "engrave/core/result.h"
#include "services/platform/command_line/description.h"

namespace intaglio::command_line {

/// Alone with a folder on the command line of any program: writes the files below and
/// ends. Not in --help: the build calls it.
inline constexpr const char* kWriteShellFiles = "--write-shell-files";

/// Writes the manual pages and completions of `program` below `share`, to the folders in
/// which man and the shells search PREFIX/share. kIo.
Status WriteShellFiles(const std::string& program, const CommandDescription& description,
                       const std::filesystem::path& share);

}  // namespace intaglio::command_line
