#include "services/platform/security/certificates.h"

#include <fmt/format.h>
#include <openssl/ec.h>
#include <openssl/err.h>
#include <openssl/pem.h>
#include <openssl/rand.h>
#include <openssl/x509v3.h>

#include "services/platform/bus/openssl_pointers.h"

namespace intaglio::security {
namespace {

using namespace bus::openssl;

tl::unexpected<Error> Refused(const char* what) {
  return Fail(ErrorCode::kFault,
              fmt::format("{} failed in the library OpenSSL: {}", what, LastError()));
}

void SetTime(ASN1_TIME* to, std::chrono::sys_seconds time) {
  ASN1_TIME_set(to, std::chrono::system_clock::to_time_t(time));
}

bool AddExtension(X509* certificate, X509* issuer, int kind, const char* value) {
  X509V3_CTX context;
  X509V3_set_ctx_nodb(&context);
  X509V3_set_ctx(&context, issuer, certificate, nullptr, nullptr, 0);
  X509_EXTENSION* extension = X509V3_EXT_conf_nid(nullptr, &context, kind, value);
  if (extension == nullptr) return false;
  const bool added = X509_add_ext(certificate, extension, -1) == 1;
  X509_EXTENSION_free(extension);
  return added;
}

bool AddName(X509* certificate, const std::string& organisation,
             const std::string& name) {
  X509_NAME* subject = X509_get_subject_name(certificate);
  const auto add = [subject](const char* field, const std::string& value) {
    return X509_NAME_add_entry_by_txt(
               subject, field, MBSTRING_UTF8,
               reinterpret_cast<const unsigned char*>(value.c_str()), -1, -1, 0) == 1;
  };
  return add("O", organisation) && add("CN", name);
}

struct Wanted {
  std::string organisation, name;
  Validity validity;
  const char* constraints;
  const char* usage;
};

/// A certificate for `key`, not signed yet; `issuer` null: its own.
Certificate Prepared(const Wanted& wanted, EVP_PKEY* key, X509* issuer) {
  Certificate certificate(X509_new());
  std::uint64_t serial = 0;
  RAND_bytes(reinterpret_cast<unsigned char*>(&serial), sizeof serial);
  X509* raw = certificate.get();
  X509* by = issuer == nullptr ? raw : issuer;
  SetTime(X509_getm_notBefore(raw), wanted.validity.begin);
  SetTime(X509_getm_notAfter(raw), wanted.validity.end);
  const bool made = X509_set_version(raw, 2) == 1 &&
                    ASN1_INTEGER_set_uint64(X509_get_serialNumber(raw), serial) == 1 &&
                    X509_set_pubkey(raw, key) == 1 &&
                    AddName(raw, wanted.organisation, wanted.name) &&
                    X509_set_issuer_name(raw, X509_get_subject_name(by)) == 1 &&
                    AddExtension(raw, by, NID_basic_constraints, wanted.constraints) &&
                    AddExtension(raw, by, NID_key_usage, wanted.usage) &&
                    AddExtension(raw, by, NID_subject_key_identifier, "hash") &&
                    AddExtension(raw, by, NID_authority_key_identifier, "keyid");
  return made ? std::move(certificate) : nullptr;
}

Result<KeyPair> PemOf(X509* certificate, EVP_PKEY* key) {
  const Memory certificate_text = NewMemory(), key_text = NewMemory();
  if (PEM_write_bio_X509(certificate_text.get(), certificate) != 1 ||
      PEM_write_bio_PrivateKey(key_text.get(), key, nullptr, nullptr, 0, nullptr,
                               nullptr) != 1) {
    return Refused("writing a certificate");
  }
  return KeyPair{TextOf(certificate_text), TextOf(key_text)};
}

Result<KeyPair> Make(const Wanted& wanted, const KeyPair* issuer) {
  const Key key(EVP_EC_gen("P-256"));
  if (!key) return Refused("making a key");
  Certificate issuer_certificate;
  Key issuer_key;
  if (issuer != nullptr) {
    issuer_certificate = ReadCertificate(issuer->certificate);
    issuer_key = ReadKey(issuer->private_key);
    if (!issuer_certificate || !issuer_key) return Refused("reading the authority");
  }
  const Certificate certificate = Prepared(wanted, key.get(), issuer_certificate.get());
  EVP_PKEY* by = issuer_key ? issuer_key.get() : key.get();
  if (!certificate || X509_sign(certificate.get(), by, EVP_sha256()) == 0) {
    return Refused("making a certificate");
  }
  return PemOf(certificate.get(), key.get());
}

}  // namespace

Result<KeyPair> NewAuthority(const std::string& organisation, const std::string& name,
                             Purpose purpose, const Validity& validity) {
  return Make({organisation, name, validity, "critical,CA:TRUE,pathlen:0",
               purpose == Purpose::kIssuer ? "critical,keyCertSign,cRLSign"
                                           : "critical,digitalSignature"},
              nullptr);
}

Result<KeyPair> NewIdentity(const KeyPair& issuer, const std::string& organisation,
                            const std::string& name, const Validity& validity) {
  return Make(
      {organisation, name, validity, "critical,CA:FALSE", "critical,digitalSignature"},
      &issuer);
}

Result<std::string> SubjectOf(const std::string& certificate) {
  const Certificate read = ReadCertificate(certificate);
  if (!read) return Refused("reading a certificate");
  return bus::openssl::SubjectOf(read.get());
}

Result<std::string> Sign(const KeyPair& signer, const std::string& text) {
  const Certificate certificate = ReadCertificate(signer.certificate);
  const Key key = ReadKey(signer.private_key);
  const Memory content = NewMemory(text), out = NewMemory();
  const int flags = PKCS7_TEXT | PKCS7_DETACHED;
  const Signed document(
      PKCS7_sign(certificate.get(), key.get(), nullptr, content.get(), flags));
  if (!document) return Refused("signing a document");
  const Memory again = NewMemory(text);
  if (SMIME_write_PKCS7(out.get(), document.get(), again.get(), flags) != 1) {
    return Refused("writing a signed document");
  }
  return TextOf(out);
}

}  // namespace intaglio::security
