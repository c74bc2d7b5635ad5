#include <fmt/format.h>
#include <openssl/err.h>
#include <openssl/x509v3.h>

#include <boost/asio/ssl/context.hpp>
#include <boost/asio/ssl/stream.hpp>

#include "services/platform/web/stream.h"

namespace intaglio::web {
namespace {

namespace ssl = boost::asio::ssl;

class Encrypted : public Transport {
 public:
  Encrypted(beast::tcp_stream stream, ssl::context& context)
      : stream_(std::move(stream), context) {}

  void Open(std::function<void(ErrorOf)> done) override {
    stream_.async_handshake(ssl::stream_base::server, std::move(done));
  }
  void Read(std::vector<net::mutable_buffer> buffers, Done done) override {
    stream_.async_read_some(buffers, std::move(done));
  }
  void Write(std::vector<net::const_buffer> buffers, Done done) override {
    stream_.async_write_some(buffers, std::move(done));
  }
  void End(std::function<void(ErrorOf)> done) override {
    stream_.async_shutdown(std::move(done));
  }
  beast::tcp_stream& tcp() override { return stream_.next_layer(); }

 private:
  ssl::stream<beast::tcp_stream> stream_;
};

/// The DNS names and addresses among the subject's alternative names.
std::vector<std::string> NamesOf(X509* certificate) {
  std::vector<std::string> names;
  auto* all = static_cast<GENERAL_NAMES*>(
      X509_get_ext_d2i(certificate, NID_subject_alt_name, nullptr, nullptr));
  for (int i = 0; all != nullptr && i < sk_GENERAL_NAME_num(all); ++i) {
    const GENERAL_NAME* name = sk_GENERAL_NAME_value(all, i);
    const ASN1_STRING* text = name->type == GEN_DNS     ? name->d.dNSName
                              : name->type == GEN_IPADD ? name->d.iPAddress
                                                        : nullptr;
    if (text == nullptr) continue;
    const auto* bytes = ASN1_STRING_get0_data(text);
    const auto size = static_cast<std::size_t>(ASN1_STRING_length(text));
    if (name->type == GEN_DNS) {
      names.emplace_back(reinterpret_cast<const char*>(bytes), size);
    } else if (size == 4) {
      names.push_back(fmt::format("{}.{}.{}.{}", bytes[0], bytes[1], bytes[2], bytes[3]));
    } else if (size == 16) {
      net::ip::address_v6::bytes_type six;
      std::copy(bytes, bytes + size, six.begin());
      names.push_back("[" + net::ip::address_v6(six).to_string() + "]");
    }
  }
  GENERAL_NAMES_free(all);
  return names;
}

class OpenSslTls : public Tls {
 public:
  Status Read(const std::string& certificate_file, const std::string& key_file) {
    ErrorOf error;
    context_.set_options(ssl::context::default_workarounds | ssl::context::no_sslv2 |
                         ssl::context::no_sslv3 | ssl::context::no_tlsv1 |
                         ssl::context::no_tlsv1_1);
    context_.use_certificate_chain_file(certificate_file, error);
    if (error) return Wrong(certificate_file, "certificate", error);
    context_.use_private_key_file(key_file, ssl::context::pem, error);
    if (error) return Wrong(key_file, "private key of this certificate", error);
    X509* certificate = SSL_CTX_get0_certificate(context_.native_handle());
    names_ = NamesOf(certificate);
    if (!names_.empty()) return {};
    return Fail(ErrorCode::kInvalidValue,
                fmt::format("{}: the certificate has no name (subjectAltName): make it "
                            "for the names by which this computer is opened",
                            certificate_file),
                certificate_file);
  }
  std::unique_ptr<Transport> Encrypt(beast::tcp_stream stream) override {
    return std::make_unique<Encrypted>(std::move(stream), context_);
  }
  const std::vector<std::string>& names() const override { return names_; }

 private:
  static Status Wrong(const std::string& file, const char* what, const ErrorOf& error) {
    return Fail(ErrorCode::kUnreadable,
                fmt::format("{}: cannot use it as the {}: {}; give a PEM file that this "
                            "user can read",
                            file, what, error.message()),
                file);
  }
  ssl::context context_{ssl::context::tls_server};
  std::vector<std::string> names_;
};

}  // namespace

Result<std::unique_ptr<Tls>> ReadTls(const std::string& certificate_file,
                                     const std::string& key_file) {
  auto tls = std::make_unique<OpenSslTls>();
  if (auto read = tls->Read(certificate_file, key_file); !read)
    return tl::unexpected(read.error());
  return tls;
}

}  // namespace intaglio::web
