#pragma once

// The folder of a shop's identities: made once, renewed before it expires, kept where no
// other user has access. Only the folders of the roles go to the hosts.
//
//   FOLDER/authority/   identity_ca.{pem,key} permissions_ca.{pem,key} shop.txt: stays
//   FOLDER/ROLE/        the six files of services/platform/bus/identity.h

#include <filesystem>
#include <string>
#include <vector>

#include "engrave/core/result.h"
#include "services/platform/security/rule_text.h"

namespace intaglio::security {

struct ShopOptions {
  std::string name = "Intaglio shop";  ///< of the authorities, for people
  std::vector<std::string> cells;      ///< machines, as in their profiles
  std::vector<int> domains = {40};     ///< control domains; bulk is the next one of each
};

struct Lifetime {
  std::chrono::sys_seconds now;
  int identity_days = 365;
  int authority_days = 3650;
};

/// New authorities and all roles. kRefused when the folder has something in it.
Status NewIdentities(const std::filesystem::path& folder, const ShopOptions& shop,
                     const Lifetime& lifetime);

/// New keys, certificates and permissions of all roles, from the authorities that are
/// there; what runs goes on until its own expires. `more_cells` are added.
Result<ShopOptions> RenewIdentities(const std::filesystem::path& folder,
                                    const std::vector<std::string>& more_cells,
                                    const Lifetime& lifetime);

}  // namespace intaglio::security
