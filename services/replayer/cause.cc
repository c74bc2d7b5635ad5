#include "services/replayer/cause.h"

#include <fmt/format.h>

#include "engrave/core/try.h"

namespace intaglio::replayer {

Status NameCause(ReplayComparison& result,
                 const std::function<Result<bool>()>& differs_again) {
  const auto report = [&result](const char* cause, std::string explanation) {
    result.set_cause(cause);
    result.set_explanation(std::move(explanation));
  };
  if (!result.options().empty()) {
    const OptionDifference& option = result.options(0);
    report("option", fmt::format("{} was {} then and is {} now", option.field(),
                                 option.then().empty() ? "not there" : option.then(),
                                 option.now().empty() ? "not there" : option.now()));
    return {};
  }
  const auto chance = INTAGLIO_TRY(differs_again());
  if (chance) {
    report("chance", "the same task, done twice now, gives two results");
  } else if (result.version_then() != result.version_now()) {
    report("version", fmt::format("recorded with version {}, compared with version {}",
                                  result.version_then(), result.version_now()));
  } else {
    report("code", fmt::format("same input, options and version {}: the code has changed",
                               result.version_now()));
  }
  return {};
}

}  // namespace intaglio::replayer
