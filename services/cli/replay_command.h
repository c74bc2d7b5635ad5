#pragma once

#include <functional>

namespace CLI {
class App;
}

namespace intaglio::cli {

/// `intaglio replay`: puts a recording back on a bus.
void AddReplayCommand(CLI::App& app, std::function<int()>& selected);

}  // namespace intaglio::cli
