#include "services/console/webhooks/webhooks.h"

#include <curl/curl.h>
#include <fmt/format.h>
#include <google/protobuf/util/json_util.h>

#include <algorithm>
#include <chrono>
#include <iostream>
#include <mutex>
#include <stop_token>
#include <thread>
#include <utility>

#include "engrave/core/check.h"
#include "engrave/core/counted.h"
#include "proto/shop.pb.h"
#include "services/console/webhooks/delivery_queue.h"
#include "services/console/webhooks/signed_request.h"
#include "services/job/files/json_text.h"
#include "services/platform/access/new_key.h"
#include "services/platform/host/times/utc_time.h"

namespace intaglio::console {
namespace {

using namespace std::chrono_literals;
using Clock = std::chrono::steady_clock;

constexpr std::chrono::milliseconds kMaxPoll = 60s;

/// The kind of an event of --events; "" of another text.
std::string KindOf(const std::string& line) {
  JobEvent event;
  google::protobuf::util::JsonParseOptions options;
  options.ignore_unknown_fields = true;
  const bool is_read =
      google::protobuf::util::JsonStringToMessage(line, &event, options).ok();
  return is_read ? event.event() : std::string();
}

/// A receiver, and what waits for it.
struct Subscriber {
  explicit Subscriber(Receiver given) : receiver(std::move(given)), transfer(receiver) {}
  const Receiver receiver;
  Transfer transfer;    // of the thread alone
  DeliveryQueue queue;  // of the mutex
  std::uint64_t dropped_in_log = 0;
  bool has_logged_drops = false;  ///< since it was delivered last
};

/// What changed by an attempt, for the log; empty: nothing that it does not have.
std::string NewsOf(Subscriber& subscriber, const WebhookAnswer& answer,
                   std::uint64_t failed_before) {
  const DeliveryQueue& queue = subscriber.queue;
  std::string news;
  if (queue.has_ended())
    news = "answered 410: it gets nothing any more until the console is started again";
  else if (answer.outcome() == DeliveryOutcome::kDelivered && failed_before > 0)
    news =
        fmt::format("delivers again after {}", Counted(failed_before, "failed attempt"));
  else if (answer.outcome() == DeliveryOutcome::kFailed && failed_before == 0)
    news = fmt::format("{}; it is tried again", answer.Sentence());
  const std::uint64_t dropped = queue.counts().dropped - subscriber.dropped_in_log;
  if (dropped > 0 && (!news.empty() || !subscriber.has_logged_drops)) {
    subscriber.dropped_in_log = queue.counts().dropped;
    subscriber.has_logged_drops = true;
    news +=
        fmt::format("{}{} dropped", news.empty() ? "" : "; ", Counted(dropped, "event"));
  }
  if (answer.outcome() == DeliveryOutcome::kDelivered)
    subscriber.has_logged_drops = false;
  return news;
}

}  // namespace

struct Webhooks::Impl {
  explicit Impl(std::vector<Receiver> receivers) {
    for (Receiver& receiver : receivers)
      subscribers.push_back(std::make_unique<Subscriber>(std::move(receiver)));
    multi.reset(curl_multi_init());
    Require(multi != nullptr, "no memory for transfers");
    thread = std::jthread([this](const std::stop_token& stop) { Run(stop); });
  }
  ~Impl() {
    thread.request_stop();
    curl_multi_wakeup(multi.get());
    thread.join();
    for (const auto& subscriber : subscribers)
      curl_multi_remove_handle(multi.get(), subscriber->transfer.handle());
  }

  /// Begins what is due; when the next attempt is.
  std::chrono::milliseconds BeginDue() {
    auto wait = kMaxPoll;
    const auto now = Clock::now();
    for (const auto& subscriber : subscribers) {
      Delivery delivery;
      std::uint64_t dropped = 0;
      {
        const std::lock_guard lock(mutex);
        const auto next = subscriber->queue.NextAttempt();
        if (!next) continue;
        if (*next > now) {
          wait =
              std::min(wait, std::chrono::ceil<std::chrono::milliseconds>(*next - now));
          continue;
        }
        delivery = subscriber->queue.Begin();
        dropped = subscriber->queue.counts().dropped;
      }
      subscriber->transfer.Prepare(HeadersOf(delivery, subscriber->receiver.secret,
                                             dropped, std::chrono::system_clock::now()),
                                   delivery.body);
      curl_multi_add_handle(multi.get(), subscriber->transfer.handle());
    }
    return wait;
  }

  void EndAttempt(CURL* handle, CURLcode code) {
    curl_multi_remove_handle(multi.get(), handle);
    const auto found = std::ranges::find_if(subscribers, [&](const auto& subscriber) {
      return subscriber->transfer.handle() == handle;
    });
    Subscriber& subscriber = **found;
    const WebhookAnswer answer = subscriber.transfer.Finish(code);
    std::string news;
    {
      const std::lock_guard lock(mutex);
      const std::uint64_t failed_before = subscriber.queue.failed_in_a_row();
      subscriber.queue.End(answer.outcome(), Clock::now());
      news = NewsOf(subscriber, answer, failed_before);
    }
    if (!news.empty()) {
      std::cerr << fmt::format("webhook {} ({}): {}\n", subscriber.receiver.name,
                               subscriber.receiver.place, news);
    }
  }

  void Run(const std::stop_token& stop) {
    while (!stop.stop_requested()) {
      const auto wait = BeginDue();
      curl_multi_poll(multi.get(), nullptr, 0, static_cast<int>(wait.count()), nullptr);
      int running = 0;
      curl_multi_perform(multi.get(), &running);
      while (const CURLMsg* message = curl_multi_info_read(multi.get(), &running)) {
        if (message->msg == CURLMSG_DONE)
          EndAttempt(message->easy_handle, message->data.result);
      }
    }
  }

  const std::string run = access::NewKey().substr(0, 16);  ///< of this console
  std::unique_ptr<CURLM, CURLMcode (*)(CURLM*)> multi{nullptr, curl_multi_cleanup};
  std::vector<std::unique_ptr<Subscriber>> subscribers;
  mutable std::mutex mutex;  // of every queue, and of what follows
  std::uint64_t published = 0;
  std::jthread thread;
};

Webhooks::Webhooks(std::vector<Receiver> receivers) {
  if (!receivers.empty()) impl_ = std::make_unique<Impl>(std::move(receivers));
}

Webhooks::~Webhooks() = default;

void Webhooks::Publish(const std::string& line) {
  if (!impl_) return;
  Delivery delivery{
      .id = {}, .event = KindOf(line), .body = std::make_shared<const std::string>(line)};
  {
    const std::lock_guard lock(impl_->mutex);
    delivery.id = fmt::format("{}-{}", impl_->run, ++impl_->published);
    for (const auto& to : impl_->subscribers) {
      if (to->receiver.Wants(delivery.event)) to->queue.Add(delivery, Clock::now());
    }
  }
  curl_multi_wakeup(impl_->multi.get());
}

std::string Webhooks::Metrics() const {
  if (!impl_) return {};
  const std::lock_guard lock(impl_->mutex);
  std::string text;
  const auto add = [&](const char* name, const char* kind, const char* help,
                       std::uint64_t (*value)(const DeliveryQueue&)) {
    text +=
        fmt::format("# HELP intaglio_webhook_{0} {2}\n# TYPE intaglio_webhook_{0} {1}\n",
                    name, kind, help);
    for (const auto& subscriber : impl_->subscribers) {
      text += fmt::format("intaglio_webhook_{}{{receiver=\"{}\"}} {}\n", name,
                          subscriber->receiver.name, value(subscriber->queue));
    }
  };
  add("delivered_total", "counter", "events that were delivered",
      [](const DeliveryQueue& queue) { return queue.counts().delivered; });
  add("failed_attempts_total", "counter", "attempts to deliver an event that failed",
      [](const DeliveryQueue& queue) { return queue.counts().failed_attempts; });
  add("dropped_total", "counter", "events that the receiver will not get",
      [](const DeliveryQueue& queue) { return queue.counts().dropped; });
  add("waiting", "gauge", "events that wait for their delivery",
      [](const DeliveryQueue& queue) -> std::uint64_t { return queue.waiting_count(); });
  add("receiver_ended", "gauge", "1: it has answered 410 and gets nothing any more",
      [](const DeliveryQueue& queue) -> std::uint64_t { return queue.has_ended(); });
  return text;
}

WebhookAnswer Ping(const Receiver& receiver) {
  JobEvent event;
  event.set_event("ping");
  event.set_time(host::UtcText(std::chrono::system_clock::now()));
  event.set_message("a test of this receiver");
  const Delivery delivery{.id = access::NewKey().substr(0, 16) + "-1",
                          .event = event.event(),
                          .body = std::make_shared<const std::string>(
                              JsonTextOf(event, JsonLayout::kOneLine).value())};
  Transfer transfer(receiver);
  transfer.Prepare(
      HeadersOf(delivery, receiver.secret, 0, std::chrono::system_clock::now()),
      delivery.body);
  return transfer.Finish(curl_easy_perform(transfer.handle()));
}

}  // namespace intaglio::console
