#pragma once

// A connection, plain or encrypted, as one type, for this folder alone: what reads and
// writes HTTP and WebSockets is compiled once, and not for each kind of connection. The
// operations of the two kinds are virtual; their handlers are std::function.

#include <boost/asio/async_result.hpp>
#include <boost/asio/buffer.hpp>
#include <boost/beast/core/role.hpp>
#include <boost/beast/core/tcp_stream.hpp>
#include <functional>
#include <memory>
#include <string>
#include <type_traits>
#include <utility>
#include <vector>

#include "engrave/core/result.h"

namespace intaglio::web {

namespace net = boost::asio;
namespace beast = boost::beast;
using ErrorOf = boost::system::error_code;

/// One connection. No function calls its handler before it has returned.
class Transport {
 public:
  using Done = std::function<void(ErrorOf, std::size_t)>;
  virtual ~Transport() = default;
  virtual void Open(std::function<void(ErrorOf)> done) = 0;  ///< the handshake, if any
  virtual void Read(std::vector<net::mutable_buffer> buffers, Done done) = 0;
  virtual void Write(std::vector<net::const_buffer> buffers, Done done) = 0;
  virtual void End(std::function<void(ErrorOf)> done) = 0;  ///< sends nothing more
  virtual beast::tcp_stream& tcp() = 0;
};

std::unique_ptr<Transport> PlainTransport(beast::tcp_stream stream);

/// The certificate of a server and its private key, as OpenSSL has them.
class Tls {
 public:
  virtual ~Tls() = default;
  virtual std::unique_ptr<Transport> Encrypt(beast::tcp_stream stream) = 0;
  /// The names and addresses that the certificate is for.
  virtual const std::vector<std::string>& names() const = 0;
};
/// Both PEM. kIo, kUnreadable: the files and what is wrong with them.
Result<std::unique_ptr<Tls>> ReadTls(const std::string& certificate_file,
                                     const std::string& key_file);

/// What Asio calls an AsyncReadStream and AsyncWriteStream.
class Stream {
 public:
  using executor_type = beast::tcp_stream::executor_type;

  explicit Stream(std::unique_ptr<Transport> transport)
      : transport_(std::move(transport)) {}

  executor_type get_executor() { return tcp().get_executor(); }
  beast::tcp_stream& tcp() const { return transport_->tcp(); }
  Transport& transport() const { return *transport_; }
  template <typename Duration>
  void expires_after(Duration time) {
    tcp().expires_after(time);
  }
  void expires_never() { tcp().expires_never(); }
  void close() { tcp().close(); }

  template <typename Buffers, typename Handler>
  auto async_read_some(const Buffers& buffers, Handler&& handler) {
    return net::async_initiate<Handler, void(ErrorOf, std::size_t)>(
        [this](auto&& taken, const Buffers& all) {
          transport_->Read(Listed<net::mutable_buffer>(all),
                           Shared(std::forward<decltype(taken)>(taken)));
        },
        handler, buffers);
  }
  template <typename Buffers, typename Handler>
  auto async_write_some(const Buffers& buffers, Handler&& handler) {
    return net::async_initiate<Handler, void(ErrorOf, std::size_t)>(
        [this](auto&& taken, const Buffers& all) {
          transport_->Write(Listed<net::const_buffer>(all),
                            Shared(std::forward<decltype(taken)>(taken)));
        },
        handler, buffers);
  }

 private:
  template <typename Buffer, typename Buffers>
  static std::vector<Buffer> Listed(const Buffers& buffers) {
    return {net::buffer_sequence_begin(buffers), net::buffer_sequence_end(buffers)};
  }
  /// Copies share a handler, which can only be moved.
  template <typename Handler>
  static Transport::Done Shared(Handler&& handler) {
    const auto shared =
        std::make_shared<std::decay_t<Handler>>(std::forward<Handler>(handler));
    return
        [shared](ErrorOf error, std::size_t count) { std::move (*shared)(error, count); };
  }

  std::unique_ptr<Transport> transport_;
};

// How Beast ends a WebSocket.
inline void beast_close_socket(Stream& stream) { stream.close(); }
template <typename Handler>
void async_teardown(beast::role_type, Stream& stream, Handler&& handler) {
  const auto shared =
      std::make_shared<std::decay_t<Handler>>(std::forward<Handler>(handler));
  stream.transport().End([shared](ErrorOf error) { std::move (*shared)(error); });
}

}  // namespace intaglio::web
