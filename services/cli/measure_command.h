#pragma once

#include <functional>

namespace CLI {
class App;
}

namespace intaglio::cli {

/// `intaglio measure`: what a cloud of points is worth. Ends with 1 when it does not keep
/// the minimum spacing.
void AddMeasureCommand(CLI::App& app, std::function<int()>& selected);

}  // namespace intaglio::cli
