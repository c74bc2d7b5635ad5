#include "services/client/warning_text.h"

#include <fmt/format.h>

namespace intaglio::client {

const char* LabelOf(const Warning& warning) {
  return warning.weight == WarningWeight::kConsent ? WarningCodeName(warning.code)
                                                   : WarningWeightName(warning.weight);
}

std::string WarningLine(const Warning& warning) {
  return fmt::format("{:<10} {}", LabelOf(warning), warning.text);
}

}  // namespace intaglio::client
