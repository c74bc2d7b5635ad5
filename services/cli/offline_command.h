#pragma once

#include <functional>

namespace CLI {
class App;
}

namespace intaglio::cli {

/// Commands that need no services: discretize, verify, render.
void AddOfflineCommands(CLI::App& app, std::function<int()>& selected);

}  // namespace intaglio::cli
