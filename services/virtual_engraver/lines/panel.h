#pragma once

// The machine's front panel: buttons and ways to misbehave, as lines of text on a
// Unix-domain socket. Each line is answered by one: "ok", "ok {...}" or "error why".

#include <filesystem>
#include <functional>
#include <string>
#include <vector>

#include "engrave/core/result.h"

namespace intaglio::virtual_engraver {

class Panel {
 public:
  using Answer = std::function<std::string(const std::string& command)>;

  static Result<Panel> Open(const std::filesystem::path& socket_path);
  Panel(Panel&& other) noexcept;
  Panel& operator=(Panel&& other) = delete;
  ~Panel();

  /// Takes connections and lines; never blocks.
  void Poll(const Answer& answer);
  /// The listening socket and the connections.
  std::vector<int> fds() const;

 private:
  struct Guest {
    int fd = -1;
    std::string unread;
  };
  Panel(std::filesystem::path path, int listener)
      : path_(std::move(path)), listener_(listener) {}
  bool Serve(Guest& guest, const Answer& answer);
  std::filesystem::path path_;
  int listener_ = -1;
  std::vector<Guest> guests_;
};

}  // namespace intaglio::virtual_engraver
