#pragma once

#include <functional>

namespace CLI {
class App;
}

namespace intaglio::cli {

/// `intaglio materials list | show | add | replace | remove | import | export`: the
/// glasses that are known. Sets `selected` when one of them is chosen; it returns
/// kExitGood or kExitWrongInput, and says on the standard error stream what was wrong.
void AddMaterialsCommand(CLI::App& app, std::function<int()>& selected);

}  // namespace intaglio::cli
