#include "services/platform/web/server.h"

#include <fmt/format.h>

#include <boost/asio/executor_work_guard.hpp>
#include <boost/asio/ip/tcp.hpp>
#include <boost/asio/post.hpp>

#include "engrave/core/check.h"
#include "engrave/core/try.h"
#include "services/platform/web/sessions.h"

namespace intaglio::web {
namespace {

using net::ip::tcp;

// After an accept failed, for example for want of file descriptors.
constexpr auto kAcceptPause = std::chrono::milliseconds(100);

}  // namespace

struct Server::Impl {
  std::unique_ptr<Core> core = std::make_unique<Core>();
  tcp::acceptor acceptor{core->io};
  net::steady_timer pause{core->io};

  void Accept() {
    acceptor.async_accept([this](ErrorOf error, tcp::socket socket) {
      if (error == net::error::operation_aborted) return;
      if (error) {
        pause.expires_after(kAcceptPause);
        pause.async_wait([this](ErrorOf) { Accept(); });
        return;
      }
      Receive(std::move(socket));
      Accept();
    });
  }

  /// A flood of connections that send no request does not keep a request out.
  void Receive(tcp::socket socket) {
    if (core->connection_count >= core->options.limits.connection_count) {
      if (core->waiting.empty()) return;
      core->waiting.front()->Close();
    }
    ErrorOf ignored;
    socket.set_option(tcp::no_delay(true), ignored);
    beast::tcp_stream stream(std::move(socket));
    StartHttp(*core, Stream(core->tls ? core->tls->Encrypt(std::move(stream))
                                      : PlainTransport(std::move(stream))));
  }
};

Server::Server(std::unique_ptr<Impl> impl) : impl_(std::move(impl)) {}

Server::~Server() = default;

Result<std::unique_ptr<Server>> Server::Open(ServerOptions options, Handlers handlers) {
  Require(!options.key.empty() || handlers.session, "a server that nobody may use");
  ErrorOf error;
  const auto address = net::ip::make_address(options.address, error);
  if (error) {
    return Fail(ErrorCode::kInvalidValue,
                fmt::format("address '{}': give an IP address of this computer, for "
                            "example 127.0.0.1, or 0.0.0.0 for all",
                            options.address),
                options.address);
  }
  auto impl = std::make_unique<Impl>();
  if (!options.certificate_file.empty()) {
    impl->core->tls = INTAGLIO_TRY(ReadTls(options.certificate_file, options.key_file));
    impl->core->own.is_encrypted = true;
    const auto& names = impl->core->tls->names();
    impl->core->own.names.insert(impl->core->own.names.begin(), names.begin(),
                                 names.end());
  } else if (!address.is_loopback()) {
    return Fail(ErrorCode::kInvalidValue,
                fmt::format("address {}: only an address of this computer (127.0.0.1) is "
                            "served without a certificate: a network needs an encrypted "
                            "connection; or use a tunnel (ssh -L)",
                            options.address),
                options.address);
  }
  Require(address.is_loopback() || options.key.empty(), "a key for a network");
  const tcp::endpoint end(address, options.port);
  impl->acceptor.open(end.protocol(), error);
  if (!error) impl->acceptor.set_option(tcp::acceptor::reuse_address(true), error);
  if (!error) impl->acceptor.bind(end, error);
  if (!error) impl->acceptor.listen(net::socket_base::max_listen_connections, error);
  if (error) {
    return Fail(
        ErrorCode::kIo,
        fmt::format("cannot serve {} port {}: {}; choose another port, or 0 for a "
                    "free one",
                    options.address, options.port, error.message()));
  }
  if (!impl->core->tls && address.is_v6())
    impl->core->own.names = {"[" + address.to_string() + "]", "localhost"};
  impl->core->own.port = impl->acceptor.local_endpoint().port();
  impl->core->options = std::move(options);
  impl->core->handlers = std::move(handlers);
  impl->Accept();
  return std::unique_ptr<Server>(new Server(std::move(impl)));
}

std::uint16_t Server::port() const { return impl_->core->own.port; }

std::string Server::origin() const { return OriginOf(impl_->core->own); }

void Server::Run() {
  const auto work = net::make_work_guard(impl_->core->io);
  impl_->core->io.run();
}

void Server::Stop() { impl_->core->io.stop(); }

void Server::Publish(const std::string& path, std::string text) {
  net::post(impl_->core->io, [core = impl_->core.get(), path, text = std::move(text)] {
    const auto shared = std::make_shared<const std::string>(text);
    std::vector<std::shared_ptr<Peer>> peers;
    for (const auto& [id, open] : core->peers) {
      if (open.path != path) continue;
      if (auto peer = open.peer.lock()) peers.push_back(std::move(peer));
    }
    for (const auto& peer : peers) peer->Send(shared);
  });
}

void Server::EndSession(std::string session) {
  net::post(impl_->core->io, [core = impl_->core.get(), session = std::move(session)] {
    std::vector<std::shared_ptr<Peer>> peers;
    for (const auto& [id, open] : core->peers) {
      if (open.session != session) continue;
      if (auto peer = open.peer.lock()) peers.push_back(std::move(peer));
    }
    for (const auto& peer : peers) peer->Close();
  });
}

void Server::Send(PeerId peer, std::string text) {
  net::post(impl_->core->io, [core = impl_->core.get(), peer, text = std::move(text)] {
    const auto found = core->peers.find(peer);
    if (found == core->peers.end()) return;
    if (const auto open = found->second.peer.lock())
      open->Send(std::make_shared<const std::string>(text));
  });
}

}  // namespace intaglio::web
