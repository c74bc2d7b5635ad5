#pragma once

#include <functional>

namespace CLI {
class App;
}

namespace intaglio::cli {

/// `intaglio batch`: a list of jobs, over the machines of a shop.
void AddBatchCommand(CLI::App& app, std::function<int()>& selected);

}  // namespace intaglio::cli
