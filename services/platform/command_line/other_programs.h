#pragma once

// What it takes to start another program of Intaglio: where it lies, and its words.

#include <filesystem>
#include <string>
#include <vector>

namespace intaglio::command_line {

/// Folder of the program that runs: the others lie beside it.
std::filesystem::path ProgramFolder();

/// As exec and posix_spawn take words; good while `words` stay as they are.
std::vector<char*> PointersTo(std::vector<std::string>& words);

}  // namespace intaglio::command_line
