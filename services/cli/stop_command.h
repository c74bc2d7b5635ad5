#pragma once

#include <functional>

namespace CLI {
class App;
}

namespace intaglio::cli {

/// intaglio stop: the emergency stop of machines, over the bus.
void AddStopCommand(CLI::App& app, std::function<int()>& selected);

}  // namespace intaglio::cli
