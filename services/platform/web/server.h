#pragma once

// A small web server: HTTP/1.1, server-sent events, WebSockets. One thread runs it;
// everything that a client can make it keep is bounded. Without a certificate it serves
// loopback alone and refuses every other address; with one every connection is encrypted
// (TLS 1.2 or later).
//
// Every request is checked here, before a handler sees it:
//   Host            an own one, else 421: no name of somebody else leads here
//   Origin          an own one where there is one, else 403: no page of somebody else
//                   sends requests or opens a WebSocket
//   caller          a key or a token, in the cookie or as "Authorization: Bearer KEY",
//                   else 401; pages and `open_paths` need none. GET /?key=KEY sets the
//                   cookie.
//
// Boost.Beast is included in this folder alone: it costs the compiler half a minute.

#include <chrono>
#include <cstdint>
#include <functional>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "engrave/core/result.h"
#include "services/platform/web/request_rules.h"

namespace intaglio::web {

/// Who sends a request.
struct Caller {
  std::string
      session;  ///< kKeySession, what Handlers::session returned, or empty: nobody
  std::string address;  ///< of the other computer
};
/// Of whoever has the server's key.
inline constexpr char kKeySession[] = "key";

struct Request {
  std::string method;  ///< "GET", "POST"
  Target target;
  std::string body;
  Caller caller;
};

struct Response {
  int status = 200;
  std::string content_type = "application/json";
  std::shared_ptr<const std::string> body;  ///< shared: a large one is not copied
  /// The token that the cookie has from now on; empty: the cookie is removed.
  std::optional<std::string> token = {};
  std::string allow = {};  ///< header Allow: methods that the path has; empty: without it
};
/// A response with a text that is its own.
Response TextResponse(int status, std::string content_type, std::string body);

/// Answers a request, once; from any thread, while the server lives.
using Reply = std::function<void(Response)>;
/// A connection that stays open; never used again in a process.
using PeerId = std::uint64_t;

struct Limits {
  std::size_t header_bytes = 8192;
  std::size_t body_bytes = 65536;
  std::size_t message_bytes = 4096;  ///< of a WebSocket, received
  /// Waiting for a slow reader; beyond it the reader is disconnected.
  std::size_t queue_bytes = 1 << 20;
  std::size_t connection_count = 512;  ///< then the one that waits longest leaves
  std::size_t peer_count = 64;         ///< open event streams and WebSockets
  std::chrono::milliseconds request_time{10'000};   ///< until a request is complete
  std::chrono::milliseconds answer_time{20'000};    ///< of a handler
  std::chrono::milliseconds write_time{10'000};     ///< for a reader to take what is sent
  std::chrono::milliseconds comment_period{5'000};  ///< of a silent event stream
};

/// Takes a long body piece by piece, in the thread of Run. Destroyed before End: the
/// connection broke, or the request was answered already.
class BodySink {
 public:
  virtual ~BodySink() = default;
  /// Not empty. `taken` asks for the next piece, from any thread: no two wait at once.
  virtual void Receive(std::string bytes, std::function<void()> taken) = 0;
  /// Everything has come: the request has to be answered now.
  virtual void End() = 0;
};

/// Called in the thread of Run; they do not wait.
struct Handlers {
  std::function<void(const Request&, Reply)> request;
  /// The form of an answer to what the server itself refuses; null: a line of text.
  std::function<Response(int status, const std::string& sentence)> refusal;
  /// The sink of a request of `long_paths`, whose body has `body_bytes`; null: it is
  /// answered without reading the body. The reply may also come while pieces come.
  std::function<std::shared_ptr<BodySink>(const Request&, std::uint64_t body_bytes,
                                          Reply)>
      body;
  /// What a new peer of a path gets first.
  std::function<std::string(const std::string& path)> greeting;
  /// A text from a WebSocket.
  std::function<void(PeerId, const Caller&, std::string)> message;
  /// The session of a token, not empty; empty: it opens none. Null: the key alone counts.
  std::function<std::string(const std::string& token)> session;
};

struct ServerOptions {
  std::string address = "127.0.0.1";
  std::uint16_t port = 0;  ///< 0: a free one
  std::string key;         ///< of whoever may use it; empty: only sessions count
  /// PEM, of the names by which the server is opened (subjectAltName); empty: no TLS.
  std::string certificate_file, key_file;
  std::map<std::string, Response> pages;  ///< by path; GET without a key
  std::vector<std::string> open_paths;    ///< of requests that need no session
  std::vector<std::string> event_paths;   ///< of server-sent events
  std::vector<std::string> socket_paths;  ///< of WebSockets
  /// What the paths of POST with a body of any length begin with.
  std::vector<std::string> long_paths;
  Limits limits;
};

class Server {
 public:
  /// kInvalidValue: no address, or not of loopback without a certificate. kIo: the port
  /// is in use. kUnreadable: the certificate.
  static Result<std::unique_ptr<Server>> Open(ServerOptions options, Handlers handlers);
  ~Server();

  std::uint16_t port() const;
  /// "https://shop.example": by the first name of its certificate.
  std::string origin() const;
  /// Until Stop; once.
  void Run();

  // From any thread.
  void Stop();
  /// To every peer of the path: an event's data, a line, or a WebSocket's text.
  void Publish(const std::string& path, std::string text);
  void Send(PeerId peer, std::string text);
  /// Closes the event streams and WebSockets of the session.
  void EndSession(std::string session);

 private:
  struct Impl;
  explicit Server(std::unique_ptr<Impl> impl);
  std::unique_ptr<Impl> impl_;
};

}  // namespace intaglio::web
