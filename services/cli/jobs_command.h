#pragma once

#include <functional>

namespace CLI {
class App;
}

namespace intaglio::cli {

/// The commands that talk to a running shop: submit, list, show, watch, arm, pause,
/// resume, cancel.
void AddJobsCommands(CLI::App& app, std::function<int()>& selected);

}  // namespace intaglio::cli
