#pragma once

// The taught positions of a profile, changed in its file, with every version before.
//
//   FILE                          the profile; `taught` in it has the newest number
//   FILE.history/000007.textproto version 7, a TaughtVersion (proto/taught.proto)
//
// A change writes its version first and then the profile, both atomically (the file is
// there whole or not at all, and durable). A process that is killed in between leaves the
// profile as it was; the version that it left is written over by the next change.
// Comments and the order of fields of a profile in text format stay.
//
// An undo restores the version before the current one, as a version with a new number, so
// that numbers only grow; a second undo goes back further. One process at a time changes
// a profile. Errors: kIo names the file, kUnreadable, kNotFound (nothing to undo).

#include <filesystem>
#include <string>
#include <vector>

#include "engrave/core/result.h"
#include "proto/machine.pb.h"
#include "proto/taught.pb.h"

namespace intaglio {

/// Who changed what, for people.
struct TaughtNote {
  std::string time_utc = {}, taught_by = {}, change = {};
};

std::filesystem::path HistoryFolderOf(const std::filesystem::path& profile);

/// Saves `taught` in the profile, with the next number, which is returned.
Result<std::uint32_t> SaveTaught(const std::filesystem::path& profile,
                                 TaughtPositions taught, const TaughtNote& note);

/// Versions up to the profile's own, oldest first; empty when nothing was taught yet.
Result<std::vector<TaughtVersion>> TaughtHistory(const std::filesystem::path& profile);

/// Restores the version before; the new one is returned. kNotFound: there is none.
Result<TaughtVersion> UndoTaught(const std::filesystem::path& profile, TaughtNote note);

/// `text` of a profile in text format with `taught` in place of what it has. Only the
/// field is changed.
std::string WithTaught(const std::string& text, const TaughtPositions& taught);

}  // namespace intaglio
