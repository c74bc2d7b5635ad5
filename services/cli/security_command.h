#pragma once

#include <functional>

namespace CLI {
class App;
}

namespace intaglio::cli {

/// `intaglio security`: makes and renews identities, and says who may do what.
void AddSecurityCommand(CLI::App& app, std::function<int()>& selected);

}  // namespace intaglio::cli
