#pragma once

// What is needed to start another program of Intaglio: its path and its arguments.

#include <filesystem>
#include <string>
#include <vector>

namespace intaglio::command_line {

/// Folder of the program that runs: the others lie beside it.
std::filesystem::path ProgramFolder();

/// Arguments as exec and posix_spawn take them; valid while `words` stay as they are.
std::vector<char*> PointersTo(std::vector<std::string>& words);

}  // namespace intaglio::command_line
