#pragma once

#include <functional>

namespace CLI {
class App;
}

namespace intaglio::cli {

/// `intaglio record`: becomes intaglio-recorder, which Ctrl-C ends.
void AddRecordCommand(CLI::App& app, std::function<int()>& selected);

}  // namespace intaglio::cli
