// SPDX-License-Identifier: BSD-3-Clause

#include "stages/view/connection.h"

#include <algorithm>
#include <cerrno>
#include <cstring>
#include <poll.h>
#include <sys/socket.h>

namespace freegs::stages {
namespace {

constexpr double kLingerSeconds = 0.5;
constexpr size_t kLingerBytes = size_t{64} << 20;

std::chrono::steady_clock::duration ToDuration(double seconds) {
  return std::chrono::duration_cast<std::chrono::steady_clock::duration>(
      std::chrono::duration<double>(seconds));
}

}  // namespace

bool OpenSockets::Add(int socket) {
  const std::lock_guard lock(mutex_);
  if (shut_down_) return false;
  sockets_.insert(socket);
  return true;
}

void OpenSockets::Remove(int socket) {
  const std::lock_guard lock(mutex_);
  sockets_.erase(socket);
}

void OpenSockets::Shutdown() {
  const std::lock_guard lock(mutex_);
  shut_down_ = true;
  for (const int socket : sockets_) shutdown(socket, SHUT_RDWR);
}

bool Connection::Wait(short events, Clock::time_point until) const {
  for (;;) {
    const auto left = std::chrono::duration_cast<std::chrono::milliseconds>(
        until - Clock::now());
    pollfd waiting = {socket_, events, 0};
    const int ready =
        poll(&waiting, 1, static_cast<int>(std::max<int64_t>(0, left.count())));
    if (ready > 0) return true;
    if (ready == 0 || errno != EINTR) return false;
  }
}

void Connection::AllowReading(size_t bytes, double seconds) {
  allowed_ = bytes;
  deadline_ = Clock::now() + ToDuration(seconds);
}

ssize_t Connection::Read(char* bytes, size_t count) {
  if (allowed_ == 0) return -1;
  if (begin_ == end_) {
    ssize_t received = -1;
    do {
      if (!Wait(POLLIN, deadline_)) return -1;
      received = recv(socket_, buffer_.data(), buffer_.size(), MSG_DONTWAIT);
    } while (received < 0 &&
             (errno == EINTR || errno == EAGAIN || errno == EWOULDBLOCK));
    if (received <= 0) return received;
    begin_ = 0;
    end_ = static_cast<size_t>(received);
  }
  const size_t given = std::min({count, end_ - begin_, allowed_});
  std::memcpy(bytes, buffer_.data() + begin_, given);
  begin_ += given;
  allowed_ -= given;
  return static_cast<ssize_t>(given);
}

ssize_t Connection::Write(const char* bytes, size_t count, double seconds) {
  const Clock::time_point until = Clock::now() + ToDuration(seconds);
  for (;;) {
    if (!Wait(POLLOUT, until)) return -1;
    const ssize_t sent =
        send(socket_, bytes, count, MSG_NOSIGNAL | MSG_DONTWAIT);
    if (sent >= 0) return sent;
    if (errno != EINTR && errno != EAGAIN && errno != EWOULDBLOCK) return -1;
  }
}

void Connection::Linger() {
  shutdown(socket_, SHUT_WR);
  AllowReading(kLingerBytes, kLingerSeconds);
  std::array<char, 4096> rest;
  while (Read(rest.data(), rest.size()) > 0) {
  }
}

}  // namespace freegs::stages
