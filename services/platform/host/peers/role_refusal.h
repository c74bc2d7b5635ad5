#pragma once

#include <string>

namespace intaglio::host {

/// What a person reads whom the access control refuses: "the role observer may not submit
/// jobs: use the identity of an operator or submitter (REASON)". `act`: "submit jobs";
/// `who`: the roles that may; `reason`: of the bus. Without a role: "this identity".
std::string RoleRefusal(const std::string& role, const std::string& act,
                        const std::string& who, const std::string& reason);

}  // namespace intaglio::host
