#pragma once

// Keys and certificates (X.509, ECDSA over P-256) and signed documents (S/MIME), as the
// security plugins of the DDS library read them.

#include <filesystem>
#include <memory>
#include <string>

#include "engrave/core/result.h"
#include "services/platform/security/rule_text.h"

namespace intaglio::security {

/// A certificate and its private key, both PEM.
struct KeyPair {
  std::string certificate;
  std::string private_key;
};

enum class Purpose {
  kIssuer,  ///< signs certificates: the identity CA
  kSigner,  ///< signs documents and no certificates: the permissions CA
};

/// A self-signed authority. Identities and permissions have different ones, so that the
/// holder of an identity cannot sign permissions for itself.
Result<KeyPair> NewAuthority(const std::string& organisation, const std::string& name,
                             Purpose purpose, const Validity& validity);

/// An identity of that common name, signed by the issuer.
Result<KeyPair> NewIdentity(const KeyPair& issuer, const std::string& organisation,
                            const std::string& name, const Validity& validity);

/// Subject of a certificate as RFC 2253, e.g. "CN=operator,O=Intaglio shop".
Result<std::string> SubjectOf(const std::string& certificate);

/// The text in a signed document (S/MIME, clear text).
Result<std::string> Sign(const KeyPair& signer, const std::string& text);

}  // namespace intaglio::security
