#pragma once

#include <functional>

namespace CLI {
class App;
}

namespace intaglio::cli {

/// `intaglio up`: the services of a shop with one machine, until Ctrl-C.
void AddUpCommand(CLI::App& app, std::function<int()>& selected);

}  // namespace intaglio::cli
