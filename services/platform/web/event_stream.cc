#include <boost/asio/write.hpp>

#include "services/platform/web/sessions.h"

namespace intaglio::web {
namespace {

class EventSession : public Peer, public std::enable_shared_from_this<EventSession> {
 public:
  EventSession(CountedPtr counted, Stream stream, std::string path, Caller caller)
      : counted_(std::move(counted)),
        core_(counted_->core()),
        stream_(std::move(stream)),
        silence_(core_.io),
        path_(std::move(path)),
        caller_(std::move(caller)),
        queue_(core_.options.limits.queue_bytes) {}
  ~EventSession() override { core_.peers.erase(id_); }

  void Start() {
    http::response<http::empty_body> head{http::status::ok, 11};
    SetSafeHeaders(head);
    head.set(http::field::content_type, "text/event-stream");
    head.set(http::field::connection, "close");
    std::string text = "HTTP/1.1 200 OK\r\n";
    for (const auto& field : head) {
      text.append(field.name_string().data(), field.name_string().size()).append(": ");
      text.append(field.value().data(), field.value().size()).append("\r\n");
    }
    text += "\r\n";
    id_ = core_.Add(path_, caller_, shared_from_this());
    Push(std::make_shared<const std::string>(std::move(text)));
    Send(std::make_shared<const std::string>(core_.handlers.greeting(path_)));
    AwaitEnd();
    Comment();
  }

  void Send(std::shared_ptr<const std::string> text) override {
    if (text->empty()) return;
    Push(std::make_shared<const std::string>("data: " + *text + "\n\n"));
  }

  void Close() override {
    closed_ = true;
    silence_.cancel();
    stream_.close();
  }

 private:
  void Push(std::shared_ptr<const std::string> text) {
    if (closed_) return;
    const bool idle = queue_.empty();
    if (!queue_.Push(std::move(text))) return Close();
    if (idle) Write();
  }

  void Write() {
    stream_.expires_after(core_.options.limits.write_time);
    net::async_write(stream_, net::buffer(queue_.front()),
                     [self = shared_from_this()](ErrorOf error, std::size_t) {
                       if (error || self->closed_) return self->Close();
                       self->queue_.Pop();
                       self->stream_.expires_never();
                       if (!self->queue_.empty()) self->Write();
                     });
  }

  /// The reader sends nothing more; what it sends is its end.
  void AwaitEnd() {
    stream_.tcp().socket().async_wait(
        net::ip::tcp::socket::wait_read,
        [self = shared_from_this()](ErrorOf) { self->Close(); });
  }

  /// A reader that is gone is found by what is sent to it.
  void Comment() {
    silence_.expires_after(core_.options.limits.comment_period);
    silence_.async_wait([self = shared_from_this()](ErrorOf error) {
      if (error || self->closed_) return;
      self->Push(std::make_shared<const std::string>(": alive\n\n"));
      self->Comment();
    });
  }

  CountedPtr counted_;
  Core& core_;
  Stream stream_;
  net::steady_timer silence_;
  std::string path_;
  Caller caller_;
  OutQueue queue_;
  PeerId id_ = 0;
  bool closed_ = false;
};

}  // namespace

void StartEvents(CountedPtr counted, Stream stream, std::string path, Caller caller) {
  std::make_shared<EventSession>(std::move(counted), std::move(stream), std::move(path),
                                 std::move(caller))
      ->Start();
}

}  // namespace intaglio::web
