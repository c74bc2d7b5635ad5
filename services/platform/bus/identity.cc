#include "services/platform/bus/identity.h"

#include <dds/dds.h>
#include <dlfcn.h>
#include <fmt/chrono.h>
#include <fmt/format.h>
#include <sys/stat.h>

#include <algorithm>
#include <cerrno>
#include <cstring>
#include <fstream>
#include <map>
#include <pugixml.hpp>
#include <sstream>

#include "engrave/core/try.h"
#include "services/platform/bus/openssl_pointers.h"

namespace intaglio::bus {
namespace {

namespace fs = std::filesystem;
using openssl::Certificate;

constexpr char kRenew[] = "renew it (intaglio security renew) and copy it here again";
constexpr char kCopyAgain[] =
    "copy the whole folder again from the place where `intaglio security` made it";
constexpr char kSecurity[] = R"(
  <Security>
    <Authentication>
      <Library path="{plugins}/libdds_security_auth.so" initFunction="init_authentication" finalizeFunction="finalize_authentication"/>
      <IdentityCA>file:{folder}/{identity_ca}</IdentityCA>
      <IdentityCertificate>file:{folder}/{certificate}</IdentityCertificate>
      <PrivateKey>file:{folder}/{key}</PrivateKey>
    </Authentication>
    <AccessControl>
      <Library path="{plugins}/libdds_security_ac.so" initFunction="init_access_control" finalizeFunction="finalize_access_control"/>
      <PermissionsCA>file:{folder}/{permissions_ca}</PermissionsCA>
      <Governance>file:{folder}/{governance}</Governance>
      <Permissions>file:{folder}/{permissions}</Permissions>
    </AccessControl>
    <Cryptographic>
      <Library path="{plugins}/libdds_security_crypto.so" initFunction="init_crypto" finalizeFunction="finalize_crypto"/>
    </Cryptographic>
  </Security>)";
constexpr auto kPlugins = {"libdds_security_auth.so", "libdds_security_ac.so",
                           "libdds_security_crypto.so"};

tl::unexpected<Error> Wrong(ErrorCode code, const fs::path& file, const std::string& what,
                            const std::string& remedy) {
  return Fail(code, fmt::format("{}: {}; {}", file.string(), what, remedy),
              file.string());
}

std::string DayOf(std::chrono::sys_seconds time) {
  return fmt::format("{:%Y-%m-%d %H:%M} UTC",
                     fmt::gmtime(std::chrono::system_clock::to_time_t(time)));
}

Result<std::string> ReadText(const fs::path& file) {
  std::ifstream in(file, std::ios::binary);
  std::ostringstream text;
  if (in && in.peek() != EOF) text << in.rdbuf();
  if (!text.str().empty()) return text.str();
  const int error = errno;
  struct stat status = {};
  if (stat(file.c_str(), &status) != 0) {
    return Wrong(ErrorCode::kNotFound, file, std::strerror(errno), kCopyAgain);
  }
  if (!in) {
    return Wrong(ErrorCode::kIo, file, std::strerror(error),
                 "give it to the user that runs this program (chown)");
  }
  return Wrong(ErrorCode::kUnreadable, file, "it is empty", kCopyAgain);
}

/// Readable and writable by its owner alone.
Status CheckSecret(const fs::path& file) {
  struct stat status = {};
  if (stat(file.c_str(), &status) == 0 && (status.st_mode & 0077) != 0) {
    return Wrong(ErrorCode::kRefused, file,
                 fmt::format("others may read this private key (mode {:o})",
                             static_cast<unsigned>(status.st_mode) & 0777U),
                 fmt::format("chmod 600 {}", file.string()));
  }
  return {};
}

Result<std::chrono::sys_seconds> TimeOf(const ASN1_TIME* time, const fs::path& file) {
  std::tm broken = {};
  if (ASN1_TIME_to_tm(time, &broken) != 1) {
    return Wrong(ErrorCode::kUnreadable, file, "its dates cannot be read", kCopyAgain);
  }
  return std::chrono::sys_seconds(std::chrono::seconds(timegm(&broken)));
}

Status CheckPeriod(const fs::path& file, const char* what, std::chrono::sys_seconds begin,
                   std::chrono::sys_seconds end, std::chrono::sys_seconds now) {
  if (now > end) {
    return Wrong(ErrorCode::kRefused, file,
                 fmt::format("{} expired on {}", what, DayOf(end)), kRenew);
  }
  if (now < begin) {
    return Wrong(ErrorCode::kRefused, file,
                 fmt::format("{} is valid from {} on, but this host's clock shows {}",
                             what, DayOf(begin), DayOf(now)),
                 "set the clock");
  }
  return {};
}

/// The folder's files, checked one after the other.
class FolderReader {
 public:
  FolderReader(const fs::path& folder, int control_domain, std::chrono::sys_seconds now)
      : identity_{folder, {}, std::chrono::sys_seconds::max()},
        control_domain_(control_domain),
        now_(now) {}

  Result<Identity> Read() {
    return ReadTexts()
        .and_then([this] { return CheckCertificates(); })
        .and_then([this] { return CheckDocument(kGovernanceFile); })
        .and_then([this] { return CheckDocument(kPermissionsFile); })
        .and_then([this] { return CheckGrant(); })
        .map([this] { return identity_; });
  }

 private:
  fs::path File(const char* name) const { return identity_.folder / name; }

  Status ReadTexts() {
    for (const char* name :
         {kCertificateFile, kPrivateKeyFile, kIdentityAuthorityFile,
          kPermissionsAuthorityFile, kGovernanceFile, kPermissionsFile}) {
      auto text = INTAGLIO_TRY(ReadText(File(name)));
      texts_[name] = std::move(text);
    }
    return CheckSecret(File(kPrivateKeyFile));
  }

  Result<Certificate> CertificateIn(const char* name) {
    Certificate certificate = openssl::ReadCertificate(texts_[name]);
    if (!certificate) {
      return Wrong(ErrorCode::kUnreadable, File(name), "it is not a certificate (PEM)",
                   kCopyAgain);
    }
    const auto begin = TimeOf(X509_get0_notBefore(certificate.get()), File(name));
    const auto end = TimeOf(X509_get0_notAfter(certificate.get()), File(name));
    if (!begin || !end) return tl::unexpected((begin ? end : begin).error());
    INTAGLIO_TRY(CheckPeriod(File(name), "the certificate", *begin, *end, now_));
    identity_.not_after = std::min(identity_.not_after, *end);
    return certificate;
  }

  Status CheckCertificates() {
    const auto own = INTAGLIO_TRY(CertificateIn(kCertificateFile));
    const auto issuer = INTAGLIO_TRY(CertificateIn(kIdentityAuthorityFile));
    auto signer = INTAGLIO_TRY(CertificateIn(kPermissionsAuthorityFile));
    signer_ = std::move(signer);
    if (X509_verify(own.get(), X509_get0_pubkey(issuer.get())) != 1) {
      return Wrong(ErrorCode::kRefused, File(kCertificateFile),
                   fmt::format("it was not signed by the authority {}",
                               File(kIdentityAuthorityFile).string()),
                   kCopyAgain);
    }
    const openssl::Key key = openssl::ReadKey(texts_[kPrivateKeyFile]);
    if (!key || X509_check_private_key(own.get(), key.get()) != 1) {
      return Wrong(ErrorCode::kRefused, File(kPrivateKeyFile),
                   fmt::format("it is not the key of {}", kCertificateFile), kCopyAgain);
    }
    subject_ = openssl::SubjectOf(own.get());
    char name[256] = {};
    X509_NAME_get_text_by_NID(X509_get_subject_name(own.get()), NID_commonName, name,
                              sizeof name);
    identity_.role = name;
    return {};
  }

  /// The signature, and then nothing but the XML is left.
  Status CheckDocument(const char* name) {
    BIO* raw_content = nullptr;
    const openssl::Signed document(
        SMIME_read_PKCS7(openssl::NewMemory(texts_[name]).get(), &raw_content));
    const openssl::Memory content(raw_content), out = openssl::NewMemory();
    const openssl::Store store(X509_STORE_new());
    X509_STORE_add_cert(store.get(), signer_.get());
    const bool good = document && PKCS7_verify(document.get(), nullptr, store.get(),
                                               content.get(), out.get(), PKCS7_TEXT) == 1;
    if (!good) {
      return Wrong(
          ErrorCode::kRefused, File(name),
          fmt::format("it was changed after it was signed, or was not signed by "
                      "the authority {} ({})",
                      File(kPermissionsAuthorityFile).string(), openssl::LastError()),
          kCopyAgain);
    }
    texts_[name] = openssl::TextOf(out);
    return {};
  }

  Status CheckGrant() {
    const fs::path file = File(kPermissionsFile);
    pugi::xml_document xml;
    xml.load_string(texts_[kPermissionsFile].c_str());
    const pugi::xml_node grant = xml.select_node("/dds/permissions/grant").node();
    if (subject_ != grant.child_value("subject_name")) {
      return Wrong(ErrorCode::kRefused, file,
                   fmt::format("it is for '{}', but the certificate is for '{}'",
                               grant.child_value("subject_name"), subject_),
                   kCopyAgain);
    }
    INTAGLIO_TRY(CheckDates(file, grant.child("validity")));
    std::string domains;
    for (const auto& found : grant.select_nodes("allow_rule[1]/domains/id")) {
      const std::string domain = found.node().child_value();
      if (domain == std::to_string(control_domain_)) return {};
      domains += (domains.empty() ? "" : ", ") + domain;
    }
    return Wrong(ErrorCode::kRefused, file,
                 fmt::format("it is for domain {}, not for {}", domains, control_domain_),
                 fmt::format("give --domain {}, or make identities with "
                             "`intaglio security new --domain {}`",
                             domains.substr(0, domains.find(',')), control_domain_));
  }

  Status CheckDates(const fs::path& file, const pugi::xml_node& validity) {
    const auto read = [&](const char* name) -> Result<std::chrono::sys_seconds> {
      std::tm broken = {};
      const char* text = validity.child_value(name);
      if (strptime(text, "%Y-%m-%dT%H:%M:%SZ", &broken) == nullptr) {
        return Wrong(ErrorCode::kUnreadable, file, fmt::format("{} is '{}'", name, text),
                     kCopyAgain);
      }
      return std::chrono::sys_seconds(std::chrono::seconds(timegm(&broken)));
    };
    const auto begin = read("not_before"), end = read("not_after");
    if (!begin || !end) return tl::unexpected((begin ? end : begin).error());
    identity_.not_after = std::min(identity_.not_after, *end);
    return CheckPeriod(file, "the permissions", *begin, *end, now_);
  }

  Identity identity_;
  int control_domain_;
  std::chrono::sys_seconds now_;
  std::map<std::string, std::string> texts_;
  Certificate signer_;
  std::string subject_;
};

/// Beside the DDS library, in the folder that Debian gives it, or with it.
Result<fs::path> PluginFolder() {
  Dl_info library = {};
  dladdr(reinterpret_cast<const void*>(&dds_create_participant), &library);
  std::error_code error;
  const fs::path beside =
      fs::canonical(library.dli_fname == nullptr ? "" : library.dli_fname, error)
          .parent_path();
  for (const fs::path& folder : {beside / "libddsc0debian", beside}) {
    const bool whole =
        std::all_of(kPlugins.begin(), kPlugins.end(),
                    [&folder](const char* name) { return fs::exists(folder / name); });
    if (whole) return folder;
  }
  return Fail(ErrorCode::kNotFound,
              fmt::format("the security plugins of the DDS library are not in {}: "
                          "install the package libddsc0debian",
                          (beside / "libddsc0debian").string()));
}

}  // namespace

fs::path IdentityFolder(const fs::path& folder, const std::vector<std::string>& roles) {
  std::error_code error;
  if (roles.empty() || fs::exists(folder / kCertificateFile, error)) return folder;
  for (const std::string& role : roles) {
    if (fs::exists(folder / role, error)) return folder / role;
  }
  return folder / roles.front();
}

Result<Identity> ReadIdentity(const fs::path& folder, int control_domain,
                              std::chrono::sys_seconds now) {
  std::error_code error;
  const fs::path absolute = fs::absolute(folder).lexically_normal();
  if (!fs::is_directory(absolute, error)) {
    return Fail(
        ErrorCode::kNotFound,
        fmt::format("--security: the folder {}{} does not exist; make identities with "
                    "`intaglio security new FOLDER` and copy this role's here",
                    absolute.string(),
                    error ? " (" + error.message() + ")" : std::string()),
        absolute.string());
  }
  if (absolute.string().find_first_of("<>&\"$") != std::string::npos) {
    return Fail(ErrorCode::kInvalidValue,
                fmt::format("--security {}: the path may not contain < > & $ or \"",
                            absolute.string()),
                absolute.string());
  }
  return FolderReader(absolute, control_domain, now).Read();
}

Result<std::string> SecurityConfiguration(const Identity& identity) {
  const auto plugins = INTAGLIO_TRY(PluginFolder());
  return fmt::format(
      kSecurity, fmt::arg("plugins", plugins.string()),
      fmt::arg("folder", identity.folder.string()),
      fmt::arg("identity_ca", kIdentityAuthorityFile),
      fmt::arg("certificate", kCertificateFile), fmt::arg("key", kPrivateKeyFile),
      fmt::arg("permissions_ca", kPermissionsAuthorityFile),
      fmt::arg("governance", kGovernanceFile), fmt::arg("permissions", kPermissionsFile));
}

}  // namespace intaglio::bus
