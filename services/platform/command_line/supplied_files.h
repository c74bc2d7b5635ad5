#pragma once

// Files that come with the programs: profiles of machines and drives, example jobs, truth
// files. They are found by the place of the program that runs, so that an installation
// can be moved.

#include <filesystem>
#include <string>
#include <vector>

#include "engrave/core/result.h"

namespace intaglio::command_line {

/// The variable of the environment that names another folder of supplied files.
inline constexpr const char* kSuppliedVariable = "INTAGLIO_SHARE";

/// Folder of the supplied files: the one that the environment names (kSuppliedVariable),
/// else PREFIX/share/intaglio for a program in PREFIX/bin. It may not exist.
std::filesystem::path SuppliedFolder();

/// A group of supplied files, files .textproto, .json and .post.
struct SuppliedKind {
  const char* folder;  ///< below the folder of the supplied files
  const char* name;    ///< for messages
};
inline constexpr SuppliedKind kSuppliedProfiles{"machines", "profile"};
inline constexpr SuppliedKind kSuppliedDrives{"drives", "drive profile"};
inline constexpr SuppliedKind kSuppliedJobs{"jobs", "job"};
inline constexpr SuppliedKind kSuppliedTemplates{"post", "template"};

/// The names by which FindSupplied finds the supplied files of a kind, sorted.
std::vector<std::string> SuppliedNames(const SuppliedKind& kind);

/// The absolute path of an existing file, or of the supplied file of this name, with
/// symbolic links followed. kNotFound: lists the supplied names, or the folder where they
/// were expected and the remedy.
Result<std::filesystem::path> FindSupplied(const std::string& name_or_file,
                                           const SuppliedKind& kind);

}  // namespace intaglio::command_line
