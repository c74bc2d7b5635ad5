#pragma once

// A recording that is made from others: it appears whole or not at all.

#include <filesystem>
#include <functional>
#include <string>
#include <vector>

#include "engrave/core/result.h"
#include "services/platform/recording/mcap_writer.h"

namespace intaglio::recording {

/// Gives what `fill` writes the name `target`. Beside it, NAME.part is written meanwhile.
/// kInvalidValue: one of both is one of the files in `sources`. Else errors of the disk,
/// and those of `fill`.
Status WriteWhole(const std::vector<std::string>& sources,
                  const std::filesystem::path& target, const std::string& library,
                  const std::function<Status(McapWriter&)>& fill);

}  // namespace intaglio::recording
