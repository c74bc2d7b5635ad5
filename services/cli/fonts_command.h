#pragma once

#include "services/platform/command_line/program.h"

namespace intaglio::cli {

/// `intaglio fonts`: the fonts of this computer that can be engraved, and which of them
/// have the characters of a text.
void AddFontsCommand(command_line::Command app);

}  // namespace intaglio::cli
