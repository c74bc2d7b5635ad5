#pragma once

// The OpenSSL objects that certificates and signed documents need, freed by themselves.

#include <openssl/err.h>
#include <openssl/pem.h>
#include <openssl/pkcs7.h>
#include <openssl/x509.h>

#include <memory>
#include <string>

namespace intaglio::bus::openssl {

template <auto free_function>
struct Freed {
  template <typename T>
  void operator()(T* object) const noexcept {
    free_function(object);
  }
};

using Certificate = std::unique_ptr<X509, Freed<X509_free>>;
using Key = std::unique_ptr<EVP_PKEY, Freed<EVP_PKEY_free>>;
using Memory = std::unique_ptr<BIO, Freed<BIO_free_all>>;
using Signed = std::unique_ptr<PKCS7, Freed<PKCS7_free>>;
using Store = std::unique_ptr<X509_STORE, Freed<X509_STORE_free>>;

inline Memory NewMemory() { return Memory(BIO_new(BIO_s_mem())); }
/// Reads from `text`, which has to live as long.
inline Memory NewMemory(const std::string& text) {
  return Memory(BIO_new_mem_buf(text.data(), static_cast<int>(text.size())));
}

inline std::string TextOf(const Memory& memory) {
  char* begin = nullptr;
  const long size = BIO_get_mem_data(memory.get(), &begin);
  return size > 0 ? std::string(begin, static_cast<std::size_t>(size)) : std::string();
}

/// Null when the PEM text is none.
inline Certificate ReadCertificate(const std::string& pem) {
  return Certificate(PEM_read_bio_X509(NewMemory(pem).get(), nullptr, nullptr, nullptr));
}
/// A key behind a password counts as none: there is no one to ask for the password.
inline Key ReadKey(const std::string& pem) {
  char no_password[] = "";
  return Key(
      PEM_read_bio_PrivateKey(NewMemory(pem).get(), nullptr, nullptr, no_password));
}

/// As RFC 2253 writes it.
inline std::string SubjectOf(X509* certificate) {
  const Memory text = NewMemory();
  X509_NAME_print_ex(text.get(), X509_get_subject_name(certificate), 0, XN_FLAG_RFC2253);
  return TextOf(text);
}

/// The library's newest complaint; it is forgotten then.
inline std::string LastError() {
  char text[256] = "no reason given";
  const unsigned long code = ERR_peek_last_error();
  if (code != 0) ERR_error_string_n(code, text, sizeof text);
  ERR_clear_error();
  return text;
}

}  // namespace intaglio::bus::openssl
