#pragma once

#include <functional>

namespace CLI {
class App;
}

namespace intaglio::cli {

/// `intaglio history`: what a shop has made.
void AddHistoryCommand(CLI::App& app, std::function<int()>& selected);

}  // namespace intaglio::cli
