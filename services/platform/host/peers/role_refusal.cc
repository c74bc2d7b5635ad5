#include "services/client/role_text.h"

#include <fmt/format.h>

namespace intaglio::client {

std::string RoleRefusal(const std::string& role, const std::string& act,
                        const std::string& who, const std::string& reason) {
  return fmt::format("{} may not {}: use the identity of an {} ({})",
                     role.empty() ? "this identity" : "the role " + role, act, who,
                     reason);
}

}  // namespace intaglio::client
