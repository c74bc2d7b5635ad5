#pragma once

#include <functional>

namespace CLI {
class App;
}

namespace intaglio::cli {

/// `intaglio recording info|list|export|repair|merge|cut`.
void AddRecordingCommand(CLI::App& app, std::function<int()>& selected);

}  // namespace intaglio::cli
