#pragma once

// The connections of a server; for this folder alone. Callbacks and no coroutines: the
// compiler of the lint and the fuzz targets, clang 14, has none that fit Debian's
// library.

#include <boost/asio/io_context.hpp>
#include <boost/asio/steady_timer.hpp>
#include <boost/beast/core/flat_buffer.hpp>
#include <boost/beast/http/buffer_body.hpp>
#include <boost/beast/http/empty_body.hpp>
#include <boost/beast/http/message.hpp>
#include <boost/beast/http/parser.hpp>
#include <boost/beast/http/string_body.hpp>
#include <deque>
#include <list>
#include <map>
#include <memory>
#include <string>

#include "services/platform/web/server.h"
#include "services/platform/web/stream.h"

namespace intaglio::web {

namespace http = boost::beast::http;
using RawRequest = http::request<http::string_body>;
/// Has read the headers of a request and nothing of its body.
using HeadParser = http::request_parser<http::empty_body>;

/// A connection that stays open and is written to.
class Peer {
 public:
  virtual ~Peer() = default;
  virtual void Send(std::shared_ptr<const std::string> text) = 0;
  virtual void Close() = 0;
};

/// A connection that waits for a request can be closed for a newer one.
class Waiting {
 public:
  virtual ~Waiting() = default;
  virtual void Close() = 0;
};

/// What the connections of a server have in common; used in its thread alone.
struct Core {
  ServerOptions options;
  Handlers handlers;
  OwnNames own;
  std::unique_ptr<Tls> tls;  ///< null: not encrypted
  std::size_t connection_count = 0;
  std::list<Waiting*> waiting;  ///< the oldest first
  PeerId last_peer = 0;
  struct OpenPeer {
    std::string path, session;
    std::weak_ptr<Peer> peer;
  };
  std::map<PeerId, OpenPeer> peers;
  /// The last, and so destroyed first: its pending handlers keep connections.
  net::io_context io{1};

  std::string CookieName() const { return "intaglio_" + std::to_string(own.port); }
  PeerId Add(const std::string& path, const Caller& caller,
             const std::shared_ptr<Peer>& peer) {
    peers[++last_peer] = {path, caller.session, peer};
    return last_peer;
  }
};

/// Counts a connection as long as it lives.
class Counted {
 public:
  explicit Counted(Core& core) : core_(core) { ++core_.connection_count; }
  Counted(const Counted&) = delete;
  Counted& operator=(const Counted&) = delete;
  ~Counted() { --core_.connection_count; }
  Core& core() const { return core_; }

 private:
  Core& core_;
};
using CountedPtr = std::shared_ptr<Counted>;

/// Texts that wait until a slow reader has taken those before.
class OutQueue {
 public:
  explicit OutQueue(std::size_t max_bytes) : max_bytes_(max_bytes) {}
  /// False: there would be too many bytes.
  bool Push(std::shared_ptr<const std::string> text) {
    bytes_ += text->size();
    texts_.push_back(std::move(text));
    return bytes_ <= max_bytes_;
  }
  bool empty() const { return texts_.empty(); }
  const std::string& front() const { return *texts_.front(); }
  void Pop() {
    bytes_ -= texts_.front()->size();
    texts_.pop_front();
  }

 private:
  std::size_t max_bytes_, bytes_ = 0;
  std::deque<std::shared_ptr<const std::string>> texts_;
};

/// Both begin with a request that was checked. They keep themselves alive.
void StartEvents(CountedPtr counted, Stream stream, std::string path, Caller caller);
void StartSocket(CountedPtr counted, Stream stream, RawRequest request, std::string path,
                 Caller caller);
/// Reads the body of a checked request for Handlers::body, answers it, and ends the
/// connection.
void StartLongBody(CountedPtr counted, Stream stream, beast::flat_buffer buffer,
                   HeadParser&& head, Request request);
/// Reads requests from a new connection.
void StartHttp(Core& core, Stream stream);

/// For a year a browser opens an encrypted server by https alone.
inline constexpr char kStrictTransport[] = "max-age=31536000";

/// Headers of every response.
template <typename Message>
void SetSafeHeaders(Message& message) {
  message.set(http::field::server, "intaglio");
  message.set(http::field::cache_control, "no-store");
  message.set("X-Content-Type-Options", "nosniff");
  message.set("Referrer-Policy", "no-referrer");
  message.set("X-Frame-Options", "DENY");
  message.set("Cross-Origin-Resource-Policy", "same-origin");
  message.set("Content-Security-Policy",
              "default-src 'none'; script-src 'self'; style-src 'self'; img-src 'self'; "
              "connect-src 'self'; worker-src 'self'; base-uri 'none'; "
              "frame-ancestors 'none'; form-action 'none'");
}

/// Status, headers and body of a response; its body has to live until it is written.
inline void Fill(http::response<http::buffer_body>& message, const Response& response,
                 const Core& core, bool keep_alive) {
  message.result(static_cast<unsigned>(response.status));
  message.version(11);
  SetSafeHeaders(message);
  if (core.own.is_encrypted)
    message.set(http::field::strict_transport_security, kStrictTransport);
  message.set(http::field::content_type, response.content_type);
  message.body() = {const_cast<char*>(response.body->data()), response.body->size(),
                    false};
  message.keep_alive(keep_alive);
  message.content_length(response.body->size());
}

}  // namespace intaglio::web
