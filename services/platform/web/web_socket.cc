#include <boost/beast/core/buffers_to_string.hpp>
#include <boost/beast/websocket/rfc6455.hpp>
#include <boost/beast/websocket/stream.hpp>

#include "services/platform/web/sessions.h"

namespace intaglio::web {
namespace {

namespace websocket = boost::beast::websocket;

class SocketSession : public Peer, public std::enable_shared_from_this<SocketSession> {
 public:
  SocketSession(CountedPtr counted, Stream stream, std::string path, Caller caller)
      : counted_(std::move(counted)),
        core_(counted_->core()),
        socket_(std::move(stream)),
        path_(std::move(path)),
        caller_(std::move(caller)),
        queue_(core_.options.limits.queue_bytes) {}
  ~SocketSession() override { core_.peers.erase(id_); }

  void Start(const std::shared_ptr<const RawRequest>& request) {
    socket_.next_layer().expires_never();
    websocket::stream_base::timeout times{};
    times.handshake_timeout = core_.options.limits.request_time;
    times.idle_timeout = core_.options.limits.write_time;
    times.keep_alive_pings = true;
    socket_.set_option(times);
    socket_.read_message_max(core_.options.limits.message_bytes);
    socket_.async_accept(*request, [self = shared_from_this(), request](ErrorOf error) {
      if (!error) self->Begin();
    });
  }

  void Send(std::shared_ptr<const std::string> text) override {
    if (closed_ || text->empty()) return;
    const bool idle = queue_.empty();
    if (!queue_.Push(std::move(text))) return Close();
    if (idle) Write();
  }

  void Close() override {
    closed_ = true;
    socket_.next_layer().close();
  }

 private:
  void Begin() {
    socket_.text(true);
    id_ = core_.Add(path_, caller_, shared_from_this());
    Send(std::make_shared<const std::string>(core_.handlers.greeting(path_)));
    Read();
  }

  void Read() {
    if (closed_) return;
    socket_.async_read(in_, [self = shared_from_this()](ErrorOf error, std::size_t) {
      if (error) return self->Close();
      std::string text = beast::buffers_to_string(self->in_.data());
      self->in_.consume(self->in_.size());
      self->core_.handlers.message(self->id_, self->caller_, std::move(text));
      self->Read();
    });
  }

  void Write() {
    socket_.async_write(net::buffer(queue_.front()),
                        [self = shared_from_this()](ErrorOf error, std::size_t) {
                          if (error || self->closed_) return self->Close();
                          self->queue_.Pop();
                          if (!self->queue_.empty()) self->Write();
                        });
  }

  CountedPtr counted_;
  Core& core_;
  websocket::stream<Stream> socket_;
  std::string path_;
  Caller caller_;
  OutQueue queue_;
  beast::flat_buffer in_;
  PeerId id_ = 0;
  bool closed_ = false;
};

}  // namespace

void StartSocket(CountedPtr counted, Stream stream, RawRequest request, std::string path,
                 Caller caller) {
  const auto kept = std::make_shared<const RawRequest>(std::move(request));
  auto session = std::make_shared<SocketSession>(std::move(counted), std::move(stream),
                                                 std::move(path), std::move(caller));
  session->Start(kept);
}

}  // namespace intaglio::web
