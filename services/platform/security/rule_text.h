#pragma once

// The two documents of DDS Security 1.1 (chapter 9.4.1), as XML.

#include <chrono>
#include <string>
#include <vector>

#include "services/platform/security/roles.h"

namespace intaglio::security {

struct Validity {
  std::chrono::sys_seconds begin, end;
};

/// How the domains are protected: everything encrypted and authenticated, no participant
/// without an identity. `domains`: control domains; bulk is the next one of each.
std::string GovernanceText(const std::vector<int>& domains);

/// What the role may do; nothing else. `subject`: of its certificate, as RFC 2253.
std::string PermissionsText(const Role& role, const std::string& subject,
                            const std::vector<int>& domains, const Validity& validity);

}  // namespace intaglio::security
