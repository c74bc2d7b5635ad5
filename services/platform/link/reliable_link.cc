#include "services/platform/link/reliable_link.h"

#include <array>
#include <random>
#include <utility>

#include "engrave/core/check.h"
#include "engrave/core/try.h"
#include "services/platform/link/byte_codec.h"

// Go-back-N. The receiver takes only the frame it expects; anything else it answers with
// a NACK that names the expected frame, at most once per `resend_after`, and the sender
// starts again from there. The sender's timer recovers from a lost NACK or a lost last
// frame; it does not run while the line has not yet taken what was sent.
//
// A host takes a number above the highest that the device knows, a random step above: of
// two that asked at the same time the lower is refused and fenced off.

namespace intaglio::link {
namespace {

using std::chrono::nanoseconds;

enum ControlFrame : std::uint8_t {
  kOpen = 0x01,       // host: its epoch, 0 asks for the highest; session in the header
  kOpened = 0x02,     // device's answer: kWaits, or nothing
  kKeepAlive = 0x03,  // also a bare acknowledgement
  kNack = 0x04,       // resend from `acknowledged`
  kRefused = 0x05,    // device's other answer: the highest epoch that opened it
};

// The payload of kOpened from a device whose time waits for its host.
constexpr std::byte kWaits{1};

constexpr std::uint64_t kMaxEpochStep = 1u << 20;

constexpr std::uint16_t kCredit = 256;
// Beyond this the line is slower than the data sent on it: wait for it. Few frames, since
// going back repeats what is still unwritten, and its acknowledgements grow old.
constexpr std::size_t kMaxUnwritten = 4 * 1024;
constexpr std::size_t kReadAtOnce = 16 * 1024;

// 0 means unsequenced, so it is passed over.
std::uint16_t Next(std::uint16_t sequence) {
  return sequence == 0xffff ? std::uint16_t{1} : static_cast<std::uint16_t>(sequence + 1);
}

}  // namespace

struct ReliableLink::State {
  State(Side link_side, std::unique_ptr<ByteStream> byte_stream, SteadyClock steady_clock,
        const LinkOptions& link_options, std::shared_ptr<LineEpoch> line_epoch)
      : side(link_side),
        stream(std::move(byte_stream)),
        clock(std::move(steady_clock)),
        options(link_options),
        epoch(std::move(line_epoch)),
        waits(link_options.waits),
        last_received(clock()) {}

  struct Frame {
    std::uint16_t sequence;
    std::uint8_t type;
    std::vector<std::byte> payload;
  };

  void StartSession(std::uint32_t number);
  void Receive(const FrameHeader& header, std::span<const std::byte> payload,
               const Handler& handler);
  bool ReceiveControl(const FrameHeader& header, std::span<const std::byte> payload);
  void ReceiveOpen(std::uint32_t of_session, std::span<const std::byte> payload);
  void ReceiveRefusal(std::span<const std::byte> payload);
  void KeepOpening(nanoseconds now);
  void AskWhetherObeyed(nanoseconds now);
  void TakeAcknowledgement(std::uint16_t acknowledged, bool resend);
  void GoBack();
  void Transmit(std::uint8_t type, std::uint16_t sequence,
                std::span<const std::byte> payload);
  void TransmitControl(ControlFrame type);
  bool Backlogged() const { return unwritten.size() - written >= kMaxUnwritten; }
  bool HasNew() const;
  bool IsPeerLate() const { return clock() - last_received > options.dead_after; }
  bool IsPeerLost() const { return !waits && IsPeerLate(); }
  void SendNew();
  void KeepTime();
  Status Write();

  Side side;
  std::unique_ptr<ByteStream> stream;
  SteadyClock clock;
  LinkOptions options;
  std::shared_ptr<LineEpoch> epoch;
  bool waits;  // for a silent peer: of a host, as the device told it
  FrameParser parser;
  Counters counters;

  std::uint32_t session = 0;
  bool established = false;
  nanoseconds last_received;
  nanoseconds last_sent{0};
  nanoseconds last_open{0};
  nanoseconds last_nack{0};
  nanoseconds last_progress{0};
  std::uint16_t next_sequence = 1;
  std::uint16_t expected = 1;
  std::uint16_t peer_credit = kCredit;
  bool owes_acknowledgement = false;
  std::deque<Frame> queue;      // sent and not acknowledged, then not sent yet
  std::size_t sent_count = 0;   // of the queue, from its front
  std::size_t known_count = 0;  // sent at least once: more than sent_count after GoBack
  std::vector<std::byte> unwritten;
  std::size_t written = 0;
};

void ReliableLink::State::StartSession(std::uint32_t number) {
  session = number;
  next_sequence = expected = 1;
  queue.clear();
  sent_count = known_count = 0;
  unwritten.clear();
  written = 0;
  owes_acknowledgement = false;
  peer_credit = kCredit;
  last_progress = clock();
}

void ReliableLink::State::Transmit(std::uint8_t type, std::uint16_t sequence,
                                   std::span<const std::byte> payload) {
  AppendFrame({type, session, sequence, expected, kCredit}, payload, unwritten);
  last_sent = clock();
  owes_acknowledgement = false;
}

// Not on a line that is behind already; the reason for it comes up again.
void ReliableLink::State::TransmitControl(ControlFrame type) {
  if (!Backlogged()) Transmit(type, 0, {});
}

void ReliableLink::State::ReceiveOpen(std::uint32_t of_session,
                                      std::span<const std::byte> payload) {
  ByteReader in(payload);
  const auto number = in.Get<std::uint64_t>();
  if (side != Side::kDevice || of_session == 0 || !in.finished()) return;
  if (number == 0 || number < epoch->number) {
    ByteWriter out;
    out.Put(epoch->number);
    if (!Backlogged()) {
      AppendFrame({kRefused, of_session, 0, 1, kCredit}, out.Take(), unwritten);
    }
    return;
  }
  epoch->number = number;
  if (of_session != session || !established) StartSession(of_session);
  established = true;
  last_received = clock();
  if (!Backlogged()) Transmit(kOpened, 0, std::span(&kWaits, waits ? 1 : 0));
}

void ReliableLink::State::ReceiveRefusal(std::span<const std::byte> payload) {
  ByteReader in(payload);
  const auto highest = in.Get<std::uint64_t>();
  if (side != Side::kHost || !in.finished()) return;
  if (epoch->number == 0) {
    const std::uint64_t step = 1 + std::random_device{}() % kMaxEpochStep;
    epoch->number = highest + step;
    epoch->fenced = epoch->number < highest;  // there is none above
    last_open = clock() - options.resend_after;
  } else if (highest > epoch->number) {
    epoch->fenced = true;
  }
  if (!epoch->fenced) return;
  established = false;
  unwritten.clear();
  written = 0;
}

bool ReliableLink::State::ReceiveControl(const FrameHeader& header,
                                         std::span<const std::byte> payload) {
  if (header.type == kOpen) {
    ReceiveOpen(header.session, payload);
    return true;
  }
  if (header.session != session || session == 0) return true;
  if (header.type == kRefused) {
    ReceiveRefusal(payload);
    return true;
  }
  if (header.type == kOpened && side == Side::kHost && !established) {
    established = true;
    waits = !payload.empty() && payload.front() == kWaits;
    last_progress = clock();
  }
  if (!established) return true;
  last_received = clock();
  return header.type == kOpened;
}

void ReliableLink::State::Receive(const FrameHeader& header,
                                  std::span<const std::byte> payload,
                                  const Handler& handler) {
  if (ReceiveControl(header, payload)) return;
  peer_credit = header.credit;
  TakeAcknowledgement(header.acknowledged, header.type == kNack);
  if (header.sequence == 0) return;
  if (header.sequence == expected) {
    expected = Next(expected);
    owes_acknowledgement = true;
    ++counters.received_frames;
    handler(header.type, payload);
    return;
  }
  ++counters.out_of_order;
  // A frame of the past was sent again because its acknowledgement was lost.
  const bool past = static_cast<std::uint16_t>(header.sequence - expected) > 0x8000;
  if (!past && clock() - last_nack >= options.resend_after) {
    last_nack = clock();
    TransmitControl(kNack);
  } else {
    owes_acknowledgement = true;
  }
}

void ReliableLink::State::TakeAcknowledgement(std::uint16_t acknowledged, bool resend) {
  std::size_t done = 0;
  while (done < known_count && queue[done].sequence != acknowledged) ++done;
  // An old acknowledgement names a frame that is gone: nothing in the queue matches it.
  if (known_count > 0 && done == known_count &&
      acknowledged != Next(queue[known_count - 1].sequence)) {
    return;
  }
  queue.erase(queue.begin(), queue.begin() + static_cast<std::ptrdiff_t>(done));
  known_count -= done;
  sent_count -= std::min(sent_count, done);
  if (done > 0) last_progress = clock();
  if (resend) GoBack();
}

void ReliableLink::State::GoBack() {
  counters.resent_frames += sent_count;
  sent_count = 0;
}

bool ReliableLink::State::HasNew() const {
  const std::size_t window = std::min<std::size_t>(options.window_frames, peer_credit);
  return established && sent_count < queue.size() && sent_count < window;
}

void ReliableLink::State::SendNew() {
  while (HasNew() && !Backlogged()) {
    const Frame& frame = queue[sent_count];
    if (sent_count == 0) last_progress = clock();
    Transmit(frame.type, frame.sequence, frame.payload);
    ++sent_count;
    known_count = std::max(known_count, sent_count);
    ++counters.sent_frames;
  }
}

void ReliableLink::State::KeepOpening(nanoseconds now) {
  if (established || session == 0) {
    // A number that no host of this line is likely to have used: a stale answer then
    // matches no host.
    StartSession(std::max<std::uint32_t>(1, std::random_device{}()));
    established = false;
    last_open = now - options.resend_after;
  }
  if (now - last_open < options.resend_after || !unwritten.empty()) return;
  last_open = now;
  ByteWriter out;
  out.Put(epoch->number);
  Transmit(kOpen, 0, out.Take());
}

// A device that waits may be silent because it obeys a newer host: its refusal says so.
void ReliableLink::State::AskWhetherObeyed(nanoseconds now) {
  if (now - last_open < options.dead_after || !unwritten.empty()) return;
  last_open = now;
  ByteWriter out;
  out.Put(std::uint64_t{0});
  Transmit(kOpen, 0, out.Take());
}

void ReliableLink::State::KeepTime() {
  if (epoch->fenced) return;
  const nanoseconds now = clock();
  if (side == Side::kHost && (!established || IsPeerLost())) return KeepOpening(now);
  if (!established) return;
  if (side == Side::kHost && IsPeerLate()) AskWhetherObeyed(now);
  if (sent_count > 0 && now - last_progress > options.resend_after) GoBack();
  SendNew();
  if (owes_acknowledgement || now - last_sent >= options.keep_alive)
    TransmitControl(kKeepAlive);
}

Status ReliableLink::State::Write() {
  while (written < unwritten.size()) {
    const auto taken = INTAGLIO_TRY(stream->Write(std::span(unwritten).subspan(written)));
    if (taken == 0) {
      // No peer can have answered what the line has not taken yet.
      last_progress = clock();
      unwritten.erase(unwritten.begin(),
                      unwritten.begin() + static_cast<std::ptrdiff_t>(written));
      written = 0;
      return {};
    }
    written += taken;
  }
  unwritten.clear();
  written = 0;
  return {};
}

ReliableLink::ReliableLink(Side side, std::unique_ptr<ByteStream> stream,
                           SteadyClock clock, const LinkOptions& options,
                           std::shared_ptr<LineEpoch> epoch)
    : state_(std::make_unique<State>(side, std::move(stream), std::move(clock), options,
                                     std::move(epoch))) {}

ReliableLink::~ReliableLink() = default;

Status ReliableLink::Poll(const Handler& handler) {
  State& s = *state_;
  std::array<std::byte, kReadAtOnce> buffer;
  for (;;) {
    const auto got = INTAGLIO_TRY(s.stream->Read(buffer));
    if (got == 0) break;
    s.parser.Feed(std::span(buffer).first(got),
                  [&](const FrameHeader& header, std::span<const std::byte> payload) {
                    s.Receive(header, payload, handler);
                  });
    if (got < buffer.size()) break;
  }
  s.counters.dropped_bytes = s.parser.dropped_bytes();
  s.counters.bad_crc = s.parser.bad_crc_count();
  s.KeepTime();
  for (;;) {
    INTAGLIO_TRY(s.Write());
    if (!s.unwritten.empty() || !s.HasNew()) return {};
    s.SendNew();
  }
}

bool ReliableLink::CanSend() const {
  return up() && state_->queue.size() < state_->options.window_frames;
}

Status ReliableLink::Send(std::uint8_t type, std::span<const std::byte> payload) {
  Require(payload.size() <= kMaxPayload, "payload of {} bytes, at most {} are allowed",
          payload.size(), kMaxPayload);
  if (!CanSend()) {
    return Fail(ErrorCode::kRefused,
                up() ? "the line's window is full" : "the line is down");
  }
  state_->queue.push_back({state_->next_sequence, type,
                           std::vector<std::byte>(payload.begin(), payload.end())});
  state_->next_sequence = Next(state_->next_sequence);
  return {};
}

bool ReliableLink::up() const { return state_->established && !state_->IsPeerLost(); }
std::uint32_t ReliableLink::session() const { return state_->session; }
nanoseconds ReliableLink::silence() const {
  return state_->clock() - state_->last_received;
}
int ReliableLink::fd() const { return state_->stream->fd(); }
bool ReliableLink::connected() const { return state_->stream->connected(); }
const ReliableLink::Counters& ReliableLink::counters() const { return state_->counters; }

}  // namespace intaglio::link
