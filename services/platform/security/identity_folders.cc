#include "services/platform/security/identity_folders.h"

#include <fmt/format.h>
#include <fmt/ranges.h>
#include <sys/stat.h>

#include <algorithm>
#include <cerrno>
#include <cstring>
#include <fstream>
#include <sstream>

#include "engrave/core/try.h"
#include "engrave/io/atomic_file.h"
#include "services/platform/bus/identity.h"
#include "services/platform/security/certificates.h"

namespace intaglio::security {
namespace {

namespace fs = std::filesystem;
using std::chrono::days;

constexpr char kAuthority[] = "authority";
constexpr char kShopFile[] = "shop.txt";
constexpr mode_t kPublic = 0644;
// Hosts whose clocks are behind take a new certificate all the same.
constexpr std::chrono::hours kClockDifference{1};

Status MakeFolder(const fs::path& folder) {
  std::error_code error;
  fs::create_directories(folder, error);
  if (!error && chmod(folder.c_str(), 0700) == 0) return {};
  const int why = error ? error.value() : errno;
  return Fail(ErrorCode::kIo,
              fmt::format("cannot write {}: {}", folder.string(), std::strerror(why)),
              folder.string());
}

Result<std::string> Read(const fs::path& file) {
  std::ifstream in(file, std::ios::binary);
  std::ostringstream text;
  text << in.rdbuf();
  if (in && !text.str().empty()) return text.str();
  return Fail(ErrorCode::kNotFound,
              fmt::format("cannot read {}: give the folder that `intaglio security new` "
                          "made, with its authority",
                          file.string()),
              file.string());
}

Status WriteAuthority(const fs::path& folder, const char* certificate,
                      const KeyPair& pair) {
  const fs::path file = folder / certificate;
  return io::WriteFileAtomically(file, pair.certificate, kPublic).and_then([&] {
    return io::WriteFileAtomically(fs::path(file).replace_extension(".key"),
                                   pair.private_key, io::kSecretMode);
  });
}

Result<KeyPair> ReadAuthority(const fs::path& folder, const char* certificate) {
  const fs::path file = folder / certificate;
  auto text = INTAGLIO_TRY(Read(file));
  auto key = INTAGLIO_TRY(Read(fs::path(file).replace_extension(".key")));
  return KeyPair{text, key};
}

struct Authorities {
  KeyPair identity, permissions;
};

Status WriteRole(const fs::path& folder, const Role& role, const ShopOptions& shop,
                 const Authorities& by, const Validity& validity) {
  const auto pair =
      INTAGLIO_TRY(NewIdentity(by.identity, shop.name, role.name, validity));
  const auto subject = INTAGLIO_TRY(SubjectOf(pair.certificate));
  const auto permissions =
      Sign(by.permissions, PermissionsText(role, subject, shop.domains, validity));
  const auto governance = Sign(by.permissions, GovernanceText(shop.domains));
  if (!permissions || !governance) {
    return tl::unexpected((permissions ? governance : permissions).error());
  }
  struct File {
    const char* name;
    const std::string& text;
    mode_t mode;
  };
  INTAGLIO_TRY(MakeFolder(folder));
  for (const File& file :
       {File{bus::kPrivateKeyFile, pair.private_key, io::kSecretMode},
        File{bus::kCertificateFile, pair.certificate, kPublic},
        File{bus::kIdentityAuthorityFile, by.identity.certificate, kPublic},
        File{bus::kPermissionsAuthorityFile, by.permissions.certificate, kPublic},
        File{bus::kGovernanceFile, *governance, kPublic},
        File{bus::kPermissionsFile, *permissions, kPublic}}) {
    INTAGLIO_TRY(io::WriteFileAtomically(folder / file.name, file.text, file.mode));
  }
  return {};
}

Status WriteRoles(const fs::path& folder, const ShopOptions& shop, const Authorities& by,
                  const Lifetime& lifetime) {
  const Validity validity{lifetime.now - kClockDifference,
                          lifetime.now + days(lifetime.identity_days)};
  for (const Role& role : RolesOf(shop.cells)) {
    if (auto written = WriteRole(folder / role.name, role, shop, by, validity); !written)
      return written;
  }
  return {};
}

/// A name of a folder, a partition and a certificate.
Status CheckName(const char* what, const std::string& name, const char* also_allowed) {
  const auto good = [also_allowed](char c) {
    return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || (c >= '0' && c <= '9') ||
           std::strchr(also_allowed, c) != nullptr;
  };
  if (!name.empty() && name.size() <= 60 && std::all_of(name.begin(), name.end(), good))
    return {};
  return Fail(ErrorCode::kInvalidValue,
              fmt::format("{} '{}': 1 to 60 letters, digits and '{}' are allowed", what,
                          name, also_allowed),
              name);
}

Status CheckShop(const ShopOptions& shop) {
  INTAGLIO_TRY(CheckName("--name", shop.name, "-_. "));
  for (const std::string& cell : shop.cells) {
    if (auto good = CheckName("--cell", cell, "-_"); !good) return good;
  }
  return {};
}

std::string ShopText(const ShopOptions& shop) {
  std::string text = fmt::format("name {}\n", shop.name);
  for (const std::string& cell : shop.cells) text += fmt::format("cell {}\n", cell);
  for (const int domain : shop.domains) text += fmt::format("domain {}\n", domain);
  return text;
}

ShopOptions ShopIn(const std::string& text) {
  ShopOptions shop;
  shop.domains.clear();
  std::istringstream lines(text);
  for (std::string line; std::getline(lines, line);) {
    const auto space = line.find(' ');
    const std::string word = line.substr(0, space);
    const std::string value = space == std::string::npos ? "" : line.substr(space + 1);
    if (word == "name") shop.name = value;
    if (word == "cell") shop.cells.push_back(value);
    if (word == "domain") shop.domains.push_back(std::atoi(value.c_str()));
  }
  return shop;
}

}  // namespace

Status NewIdentities(const fs::path& folder, const ShopOptions& shop,
                     const Lifetime& lifetime) {
  INTAGLIO_TRY(CheckShop(shop));
  std::error_code error;
  if (fs::exists(folder, error) && !fs::is_empty(folder, error)) {
    return Fail(ErrorCode::kRefused,
                fmt::format("{} is not empty: `intaglio security renew` renews "
                            "identities, new ones need an empty folder",
                            folder.string()),
                folder.string());
  }
  const Validity validity{lifetime.now - kClockDifference,
                          lifetime.now + days(lifetime.authority_days)};
  const auto identity =
      NewAuthority(shop.name, "identity authority", Purpose::kIssuer, validity);
  const auto permissions =
      NewAuthority(shop.name, "permissions authority", Purpose::kSigner, validity);
  if (!identity || !permissions) {
    return tl::unexpected((identity ? permissions : identity).error());
  }
  const fs::path authority = folder / kAuthority;
  return MakeFolder(folder)
      .and_then([&] { return MakeFolder(authority); })
      .and_then([&] {
        return WriteAuthority(authority, bus::kIdentityAuthorityFile, *identity);
      })
      .and_then([&] {
        return WriteAuthority(authority, bus::kPermissionsAuthorityFile, *permissions);
      })
      .and_then([&] {
        return io::WriteFileAtomically(authority / kShopFile, ShopText(shop), kPublic);
      })
      .and_then([&] {
        return WriteRoles(folder, shop, {*identity, *permissions}, lifetime);
      });
}

Result<ShopOptions> RenewIdentities(const fs::path& folder,
                                    const std::vector<std::string>& more_cells,
                                    const Lifetime& lifetime) {
  const fs::path authority = folder / kAuthority;
  const auto text = INTAGLIO_TRY(Read(authority / kShopFile));
  const auto identity =
      INTAGLIO_TRY(ReadAuthority(authority, bus::kIdentityAuthorityFile));
  const auto permissions =
      INTAGLIO_TRY(ReadAuthority(authority, bus::kPermissionsAuthorityFile));
  ShopOptions shop = ShopIn(text);
  for (const std::string& cell : more_cells) {
    if (std::find(shop.cells.begin(), shop.cells.end(), cell) == shop.cells.end())
      shop.cells.push_back(cell);
  }
  return CheckShop(shop)
      .and_then([&] {
        return io::WriteFileAtomically(authority / kShopFile, ShopText(shop), kPublic);
      })
      .and_then([&] {
        return WriteRoles(folder, shop, {identity, permissions}, lifetime);
      })
      .map([&] { return shop; });
}

}  // namespace intaglio::security
