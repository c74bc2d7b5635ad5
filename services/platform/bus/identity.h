#pragma once

// The identity of a process on a secured bus: a folder of six files, made by `intaglio
// security`.
//
// The security plugins of the DDS library check the same again and are what protects the
// shop; this check reports to an honest program in advance what is wrong with its files.

#include <chrono>
#include <filesystem>
#include <string>
#include <vector>

#include "engrave/core/result.h"

namespace intaglio::bus {

/// Files of an identity, in its folder.
inline constexpr char kCertificateFile[] = "certificate.pem";
inline constexpr char kPrivateKeyFile[] = "private_key.pem";
inline constexpr char kIdentityAuthorityFile[] = "identity_ca.pem";
inline constexpr char kPermissionsAuthorityFile[] = "permissions_ca.pem";
inline constexpr char kGovernanceFile[] = "governance.p7s";
inline constexpr char kPermissionsFile[] = "permissions.p7s";

struct Identity {
  std::filesystem::path folder;        ///< absolute
  std::string role;                    ///< common name of the certificate
  std::chrono::sys_seconds not_after;  ///< the first of its documents ends then
};

/// `folder` when it is an identity itself, else that of the first of `roles` below it
/// that is there; of the first role when none is.
std::filesystem::path IdentityFolder(const std::filesystem::path& folder,
                                     const std::vector<std::string>& roles);

/// Checks all files; the message names the file that is wrong and the remedy.
/// `control_domain`: has to be among those that the permissions are for.
Result<Identity> ReadIdentity(const std::filesystem::path& folder, int control_domain,
                              std::chrono::sys_seconds now);

/// The part <Security> of the DDS library's configuration. kNotFound: the library was
/// installed without its security plugins.
Result<std::string> SecurityConfiguration(const Identity& identity);

}  // namespace intaglio::bus
