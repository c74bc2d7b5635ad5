#pragma once

// Names of the folders that commands make when none is given: one word in every shell and
// in every file system.

#include <string>

namespace intaglio::client {

/// "trefoil knot: no. 3" -> "trefoil_knot_no._3". Letters and digits of any script, '.',
/// '-' and '_' stay; whatever lies between becomes one '_'. At most 100 bytes, cut
/// between characters; "job" where nothing is left. It does not begin with '-' or '.'.
std::string FolderNameOf(const std::string& job_name);

/// "2026-11-27T05:05:21Z" -> "2026-11-27T050521Z".
std::string FolderTimeOf(const std::string& utc);

}  // namespace intaglio::client
