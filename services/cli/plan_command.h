#pragma once

#include <functional>

namespace CLI {
class App;
}

namespace intaglio::cli {

/// Commands that make or take a path, without services: sort, plan.
void AddPathCommands(CLI::App& app, std::function<int()>& selected);

}  // namespace intaglio::cli
