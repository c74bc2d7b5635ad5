// What libusb-1.0 has that services/platform/link/usb_device.cc calls, without USB. It
// replaces the library in a program that it is linked into, and in any other as a shared
// library.
//
// The folder INTAGLIO_FAKE_USB is the bus: each file "BUS-PORT.PORT..." is a BJJCZ board
// at that place, a Unix-domain socket or a pseudo-terminal that has its bytes. Files
// beside it: PLACE.denied, nobody may open it; PLACE.sent, which gets a line with the
// size of each transfer to the board.

#include <fcntl.h>
#include <libusb.h>
#include <poll.h>
#include <sys/file.h>
#include <sys/socket.h>
#include <sys/stat.h>
#include <sys/un.h>
#include <termios.h>
#include <unistd.h>

#include <cerrno>
#include <chrono>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <string>
#include <vector>

namespace fs = std::filesystem;

struct libusb_context {};

struct libusb_device {
  fs::path path;
  int references = 1;
};

struct libusb_device_handle {
  fs::path path;
  int bytes = -1, lock = -1;
};

namespace {

fs::path Beside(const fs::path& path, const char* what) {
  return path.string() + "." + what;
}

int OpenBytes(const fs::path& path) {
  struct stat about {};
  if (stat(path.c_str(), &about) != 0) return -1;
  if (!S_ISSOCK(about.st_mode)) {
    const int tty = open(path.c_str(), O_RDWR | O_NONBLOCK | O_NOCTTY | O_CLOEXEC);
    termios raw{};
    if (tty >= 0 && tcgetattr(tty, &raw) == 0) {
      cfmakeraw(&raw);
      tcsetattr(tty, TCSANOW, &raw);
    }
    return tty;
  }
  const int made = socket(AF_UNIX, SOCK_STREAM | SOCK_NONBLOCK | SOCK_CLOEXEC, 0);
  sockaddr_un at{};
  at.sun_family = AF_UNIX;
  path.string().copy(at.sun_path, sizeof at.sun_path - 1);
  if (connect(made, reinterpret_cast<const sockaddr*>(&at), sizeof at) == 0) return made;
  close(made);
  return -1;
}

/// Without SIGPIPE where it is a socket.
ssize_t SendBytes(int bytes, const unsigned char* from, std::size_t size) {
  const ssize_t done = send(bytes, from, size, MSG_NOSIGNAL);
  return done < 0 && errno == ENOTSOCK ? write(bytes, from, size) : done;
}

/// A time that has passed, or an error; `moved` bytes were.
int Move(libusb_device_handle* handle, bool out, unsigned char* bytes, int count,
         int* moved, int timeout_ms) {
  pollfd state{handle->bytes, static_cast<short>(out ? POLLOUT : POLLIN), 0};
  if (!fs::exists(fs::symlink_status(handle->path))) return LIBUSB_ERROR_NO_DEVICE;
  if (poll(&state, 1, timeout_ms) == 0) return LIBUSB_ERROR_TIMEOUT;
  const auto size = static_cast<std::size_t>(count);
  const ssize_t done =
      out ? SendBytes(handle->bytes, bytes, size) : read(handle->bytes, bytes, size);
  if (done < 0 && (errno == EAGAIN || errno == EINTR)) return LIBUSB_ERROR_TIMEOUT;
  if (done <= 0) return LIBUSB_ERROR_NO_DEVICE;
  *moved = static_cast<int>(done);
  return *moved == count || !out ? LIBUSB_SUCCESS : LIBUSB_ERROR_TIMEOUT;
}

}  // namespace

extern "C" {

int libusb_init(libusb_context** context) {
  static libusb_context only;
  *context = &only;
  return LIBUSB_SUCCESS;
}

ssize_t libusb_get_device_list(libusb_context* /*context*/, libusb_device*** list) {
  std::vector<libusb_device*> found;
  const char* folder = std::getenv("INTAGLIO_FAKE_USB");
  std::error_code ignored;
  for (fs::directory_iterator at(folder == nullptr ? "" : folder, ignored), end;
       at != end; at.increment(ignored)) {
    const std::string name = at->path().filename();
    if (name.find_first_not_of("0123456789-.") == std::string::npos)
      found.push_back(new libusb_device{at->path()});
  }
  *list = new libusb_device*[found.size() + 1];
  std::copy(found.begin(), found.end(), *list);
  (*list)[found.size()] = nullptr;
  return static_cast<ssize_t>(found.size());
}

void libusb_free_device_list(libusb_device** list, int unreference) {
  for (libusb_device** at = list; unreference != 0 && *at != nullptr; ++at) delete *at;
  delete[] list;
}

int libusb_get_device_descriptor(libusb_device* /*device*/,
                                 libusb_device_descriptor* about) {
  about->idVendor = 0x9588;
  about->idProduct = 0x9899;
  return LIBUSB_SUCCESS;
}

std::uint8_t libusb_get_bus_number(libusb_device* device) {
  return static_cast<std::uint8_t>(std::stoi(device->path.filename().string()));
}

int libusb_get_port_numbers(libusb_device* device, std::uint8_t* ports, int count) {
  std::string name = device->path.filename().string();
  int found = 0;
  for (auto at = name.find_first_of("-."); at != std::string::npos && found < count;
       at = name.find_first_of("-.", at + 1))
    ports[found++] = static_cast<std::uint8_t>(std::stoi(name.substr(at + 1)));
  return found;
}

int libusb_open(libusb_device* device, libusb_device_handle** handle) {
  if (fs::exists(Beside(device->path, "denied"))) return LIBUSB_ERROR_ACCESS;
  *handle = new libusb_device_handle{device->path};
  return LIBUSB_SUCCESS;
}

int libusb_set_auto_detach_kernel_driver(libusb_device_handle*, int) {
  return LIBUSB_SUCCESS;
}

int libusb_claim_interface(libusb_device_handle* handle, int /*interface*/) {
  handle->lock =
      open(Beside(handle->path, "lock").c_str(), O_RDWR | O_CREAT | O_CLOEXEC, 0600);
  if (flock(handle->lock, LOCK_EX | LOCK_NB) != 0) return LIBUSB_ERROR_BUSY;
  handle->bytes = OpenBytes(handle->path);
  return handle->bytes >= 0 ? LIBUSB_SUCCESS : LIBUSB_ERROR_NO_DEVICE;
}

int libusb_release_interface(libusb_device_handle*, int) { return LIBUSB_SUCCESS; }

void libusb_close(libusb_device_handle* handle) {
  if (handle->bytes >= 0) close(handle->bytes);
  if (handle->lock >= 0) close(handle->lock);
  delete handle;
}

int libusb_bulk_transfer(libusb_device_handle* handle, unsigned char endpoint,
                         unsigned char* bytes, int count, int* moved,
                         unsigned int timeout_ms) {
  if (endpoint != 0x02 && endpoint != 0x88) return LIBUSB_ERROR_PIPE;
  const bool out = endpoint == 0x02;
  *moved = 0;
  const auto end =
      std::chrono::steady_clock::now() + std::chrono::milliseconds(timeout_ms);
  int error = LIBUSB_SUCCESS;
  do {
    int done = 0;
    error = Move(handle, out, bytes + *moved, count - *moved, &done,
                 static_cast<int>(timeout_ms));
    *moved += done;
  } while (out && error == LIBUSB_ERROR_TIMEOUT && *moved > 0 &&
           std::chrono::steady_clock::now() < end);
  if (out && fs::exists(Beside(handle->path, "sent")))
    std::ofstream(Beside(handle->path, "sent"), std::ios::app) << *moved << '\n';
  return error;
}

const char* libusb_error_name(int error) {
  switch (error) {
    case LIBUSB_ERROR_ACCESS:
      return "LIBUSB_ERROR_ACCESS";
    case LIBUSB_ERROR_BUSY:
      return "LIBUSB_ERROR_BUSY";
    case LIBUSB_ERROR_NO_DEVICE:
      return "LIBUSB_ERROR_NO_DEVICE";
    default:
      return "LIBUSB_ERROR_OTHER";
  }
}

}  // extern "C"
