#pragma once

// Truth files: protobuf text format of proto/truth.proto.

#include <filesystem>
#include <string>
#include <string_view>

#include "engrave/core/result.h"
#include "proto/truth.pb.h"

namespace intaglio {

/// A truth file is below 1 kB; this leaves room for comments.
inline constexpr std::size_t kMaxTruthFileBytes = 1 << 20;

/// Checked: the machine can be started with it. kNotFound, kIo, kTooLarge; kUnreadable
/// with "file:line:column: what", an unknown field, too; kInvalidValue with every wrong
/// value, one a line: "file: field: value is outside min..max".
Result<MachineTruth> ReadTruthFile(const std::filesystem::path& file);

/// The same from memory; `name` is given for the file in errors.
Result<MachineTruth> ParseTruth(std::string_view text, const std::string& name);

/// What `changes` sets replaces the value in `truth`; of messages field by field, of the
/// rates, of the channels' places, of the stations and of the obstacles all.
void Replace(const MachineTruth& changes, MachineTruth& truth);

/// The file is there whole or not at all.
Status WriteTruthFile(const std::filesystem::path& file, const MachineTruth& truth);

}  // namespace intaglio
