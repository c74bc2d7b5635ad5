#include "services/platform/host/peers/role_refusal.h"

#include <fmt/format.h>

namespace intaglio::host {

std::string RoleRefusal(const std::string& role, const std::string& act,
                        const std::string& who, const std::string& reason) {
  return fmt::format("{} may not {}: use the identity of an {} ({})",
                     role.empty() ? "this identity" : "the role " + role, act, who,
                     reason);
}

}  // namespace intaglio::host
