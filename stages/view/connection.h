// SPDX-License-Identifier: BSD-3-Clause
// The bytes of one connection, with limits of time and size.

#ifndef FREEGS_STAGES_VIEW_CONNECTION_H_
#define FREEGS_STAGES_VIEW_CONNECTION_H_

#include <array>
#include <chrono>
#include <cstddef>
#include <mutex>
#include <set>
#include <sys/types.h>

namespace freegs::stages {

// The sockets that are open, so that all can be ended at once. Several threads
// may use it.
class OpenSockets {
 public:
  // False when Shutdown was called before; the socket is not noted then.
  bool Add(int socket);
  void Remove(int socket);

  // Ends the reading and writing of all sockets. Those who use them still have
  // to close them.
  void Shutdown();

 private:
  std::mutex mutex_;
  std::set<int> sockets_;
  bool shut_down_ = false;
};

class Connection {
 public:
  // Does not own the socket.
  explicit Connection(int socket) : socket_(socket) {}

  // From now on at most `bytes` may be read, within `seconds`; what is read
  // beyond is an error.
  void AllowReading(size_t bytes, double seconds);

  // Returns the number of bytes read, 0 at the end, -1 on errors.
  ssize_t Read(char* bytes, size_t count);

  // Waits at most `seconds` until some bytes are taken. Returns their number,
  // -1 on errors.
  ssize_t Write(const char* bytes, size_t count, double seconds);

  // Ends the writing and reads what the client still sends, for a moment: when
  // a socket is closed with unread bytes, the client may lose the answer.
  void Linger();

 private:
  using Clock = std::chrono::steady_clock;

  bool Wait(short events, Clock::time_point until) const;

  const int socket_;
  size_t allowed_ = 0;
  Clock::time_point deadline_;

  // The library reads headers byte by byte.
  std::array<char, 4096> buffer_;
  size_t begin_ = 0;
  size_t end_ = 0;
};

}  // namespace freegs::stages

#endif  // FREEGS_STAGES_VIEW_CONNECTION_H_
