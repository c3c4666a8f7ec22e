// SPDX-License-Identifier: BSD-3-Clause
// Running other programs.

#include "sfm/colmap/child_process.h"

#include <algorithm>
#include <cerrno>
#include <chrono>
#include <csignal>
#include <cstring>
#include <deque>
#include <fcntl.h>
#include <memory>
#include <poll.h>
#include <sys/prctl.h>
#include <sys/wait.h>
#include <unistd.h>

extern char** environ;

namespace freegs::sfm {
namespace {

constexpr size_t kMaxLine = 1 << 16;  // Longer lines are cut into pieces.
constexpr size_t kTailLines = 15;
constexpr int kPollMilliseconds = 50;
constexpr int kClosedMicroseconds = 5000;
constexpr auto kGracePeriod = std::chrono::seconds(2);

std::string ErrorText(const std::string& call) {
  return call + ": " + std::strerror(errno);
}

// A file descriptor that closes itself.
class Descriptor {
 public:
  explicit Descriptor(int fd = -1) : fd_(fd) {}
  Descriptor(Descriptor&& other) noexcept : fd_(std::exchange(other.fd_, -1)) {}
  Descriptor& operator=(Descriptor&& other) noexcept {
    std::swap(fd_, other.fd_);
    return *this;
  }
  ~Descriptor() { Close(); }
  int get() const { return fd_; }
  void Close() {
    if (fd_ >= 0) close(fd_);
    fd_ = -1;
  }

 private:
  int fd_;
};

Status MakePipe(Descriptor* read_end, Descriptor* write_end) {
  int ends[2];
  if (pipe2(ends, O_CLOEXEC) != 0) return InternalError(ErrorText("pipe2"));
  *read_end = Descriptor(ends[0]);
  *write_end = Descriptor(ends[1]);
  return {};
}

// What a child needs, prepared before vfork: until it executes its program it
// runs in the memory of this process, which waits for it, and may only make
// async-signal-safe calls (other threads may hold locks). With fork, this
// process would then copy each page of its memory that it writes to.
struct Launch {
  std::vector<std::string> strings;  // Owns the texts behind the pointers.
  std::vector<char*> argv;
  std::vector<char*> environment;
  int stdin_fd = -1;
  int stdout_fd = -1;
  int error_fd = -1;  // Tells the parent errno when exec fails.
  pid_t parent = 0;
  pid_t group = 0;
};

// All signals wait while it lives, because a child of vfork must not run this
// process's handlers.
class SignalsWait {
 public:
  SignalsWait() {
    sigset_t all;
    sigfillset(&all);
    pthread_sigmask(SIG_SETMASK, &all, &before_);
  }
  ~SignalsWait() { pthread_sigmask(SIG_SETMASK, &before_, nullptr); }
  SignalsWait(const SignalsWait&) = delete;
  SignalsWait& operator=(const SignalsWait&) = delete;

 private:
  sigset_t before_;
};

// dup2 does so unless both numbers are the same, which happens when this
// process was started with its standard input closed.
void KeepOnExec(int fd) { fcntl(fd, F_SETFD, 0); }

// Ends a child that could not execute its program.
[[noreturn]] void TellErrno(int error_fd) {
  const int error = errno;
  [[maybe_unused]] const ssize_t written =
      write(error_fd, &error, sizeof(error));
  _exit(127);
}

// The guard of a program: leads its process group, and kills the group when
// this process ends in whatever way. `lifeline` is the end of a pipe that this
// process holds open at the other end. As long as the guard has not been waited
// for, no other group can get its number. It keeps the signal mask: signals for
// the group are not meant for it.
[[noreturn]] void ExecGuard(int lifeline, int error_fd) {
  setpgid(0, 0);
  dup2(lifeline, STDIN_FILENO);
  KeepOnExec(STDIN_FILENO);
  close_range(STDIN_FILENO + 1, ~0U, CLOSE_RANGE_CLOEXEC);
  // Reading ends when the last holder of the pipe's other end does.
  execl("/bin/sh", "sh", "-c", "read -r line; kill -KILL 0", nullptr);
  TellErrno(error_fd);
}

[[noreturn]] void ExecChild(const Launch& launch) {
  // The group is ours to kill; a terminal's Ctrl-C reaches only the parent.
  setpgid(0, launch.group);
  // Killed with the parent. If the parent died before this call, nobody would
  // tell: so look.
  prctl(PR_SET_PDEATHSIG, SIGKILL);
  if (getppid() != launch.parent) _exit(127);

  struct sigaction action = {};
  action.sa_handler = SIG_DFL;
  for (const int signal : {SIGINT, SIGTERM, SIGPIPE, SIGHUP, SIGCHLD}) {
    sigaction(signal, &action, nullptr);
  }
  sigset_t none;
  sigemptyset(&none);
  sigprocmask(SIG_SETMASK, &none, nullptr);

  dup2(launch.stdin_fd, STDIN_FILENO);
  dup2(launch.stdout_fd, STDOUT_FILENO);
  dup2(launch.stdout_fd, STDERR_FILENO);
  for (const int fd : {STDIN_FILENO, STDOUT_FILENO, STDERR_FILENO}) {
    KeepOnExec(fd);
  }
  // Nothing else of ours (locks, files) goes along.
  close_range(3, ~0U, CLOSE_RANGE_CLOEXEC);
  execvpe(launch.argv[0], launch.argv.data(), launch.environment.data());
  TellErrno(launch.error_fd);
}

std::vector<std::string> EnvironmentWith(
    const std::vector<std::pair<std::string, std::string>>& changes) {
  std::vector<std::string> result;
  for (char** entry = environ; entry != nullptr && *entry != nullptr; ++entry) {
    const std::string_view text(*entry);
    const std::string_view name = text.substr(0, text.find('='));
    if (std::none_of(changes.begin(), changes.end(), [&](const auto& change) {
          return change.first == name;
        })) {
      result.emplace_back(text);
    }
  }
  for (const auto& [name, value] : changes)
    result.push_back(name + "=" + value);
  return result;
}

// One running program.
class Child {
 public:
  Child() = default;
  Child(const Child&) = delete;
  Child& operator=(const Child&) = delete;
  ~Child() { Kill(); }

  Status Start(const ChildCommand& command);

  int output() const { return output_.get(); }

  // Reads what is there without waiting; false once the output has ended.
  bool ReadOutput(const LineFn& on_line);

  // True when the program has ended.
  bool Reap(bool wait);

  // The result of a program that has ended, with what it wrote between the
  // last read and its end.
  ChildResult Finish(const LineFn& on_line);

  void Signal(int signal) {
    if (group_ > 0) kill(-group_, signal);
  }

  // Ends the program and all of its group at once.
  void Kill() {
    Signal(SIGKILL);
    Reap(true);
    EndGroup();
  }

  // Ends the program when its time is over.
  void KillWhenOverdue() {
    if (pid_ <= 0 || result_.time_limit_s <= 0) return;
    const std::chrono::duration<double> ran =
        std::chrono::steady_clock::now() - start_;
    if (ran.count() < result_.time_limit_s) return;
    result_.timed_out = true;
    Signal(SIGKILL);
  }

 private:
  Status StartGuard(int error_fd);
  void EndGroup();
  void TakeLine(const LineFn& on_line);

  pid_t pid_ = -1;
  pid_t group_ = -1;     // The program's; also the process id of its guard.
  Descriptor lifeline_;  // Closed by the kernel when this process ends.
  Descriptor output_;
  Descriptor log_;
  std::string line_;
  std::deque<std::string> tail_;
  ChildResult result_;
  std::chrono::steady_clock::time_point start_;
};

Status Child::StartGuard(int error_fd) {
  Descriptor read_end;
  FREEGS_RETURN_IF_ERROR(MakePipe(&read_end, &lifeline_));
  const SignalsWait signals;
  group_ = vfork();
  if (group_ == 0) ExecGuard(read_end.get(), error_fd);
  if (group_ < 0) return InternalError(ErrorText("vfork"));
  // Here too, for systems where vfork does not wait.
  setpgid(group_, group_);
  return {};
}

Status Child::Start(const ChildCommand& command) {
  if (command.argv.empty()) return InternalError("no program to run");
  Descriptor output_write;
  Descriptor error_read;
  Descriptor error_write;
  FREEGS_RETURN_IF_ERROR(MakePipe(&output_, &output_write));
  FREEGS_RETURN_IF_ERROR(MakePipe(&error_read, &error_write));
  const Descriptor input(open("/dev/null", O_RDONLY | O_CLOEXEC));
  if (input.get() < 0) return InternalError(ErrorText("/dev/null"));
  if (!command.log_file.empty()) {
    log_ = Descriptor(open(command.log_file.c_str(),
                           O_WRONLY | O_CREAT | O_APPEND | O_CLOEXEC,
                           0666));
    if (log_.get() < 0) {
      return InternalError(ErrorText(command.log_file.string()));
    }
  }

  result_.time_limit_s = command.time_limit_s;
  start_ = std::chrono::steady_clock::now();
  Launch launch;
  launch.strings = command.argv;
  const std::vector<std::string> environment =
      EnvironmentWith(command.environment);
  launch.strings.insert(
      launch.strings.end(), environment.begin(), environment.end());
  for (size_t i = 0; i < launch.strings.size(); ++i) {
    (i < command.argv.size() ? launch.argv : launch.environment)
        .push_back(launch.strings[i].data());
  }
  launch.argv.push_back(nullptr);
  launch.environment.push_back(nullptr);
  launch.stdin_fd = input.get();
  launch.stdout_fd = output_write.get();
  launch.error_fd = error_write.get();
  launch.parent = getpid();
  FREEGS_RETURN_IF_ERROR(StartGuard(launch.error_fd));
  launch.group = group_;

  {
    const SignalsWait signals;
    pid_ = vfork();
    if (pid_ == 0) ExecChild(launch);
  }
  if (pid_ < 0) return InternalError(ErrorText("vfork"));
  setpgid(pid_, group_);
  error_write.Close();
  output_write.Close();
  int error = 0;
  ssize_t count;
  do {
    count = read(error_read.get(), &error, sizeof(error));
  } while (count < 0 && errno == EINTR);
  if (count == static_cast<ssize_t>(sizeof(error))) {
    Kill();
    return MissingDependencyError(
        command.argv[0] + ": cannot be started: " + std::strerror(error));
  }
  fcntl(output_.get(), F_SETFL, O_NONBLOCK);
  return {};
}

void Child::TakeLine(const LineFn& on_line) {
  if (line_.empty()) return;
  if (on_line) on_line(line_);
  tail_.push_back(std::move(line_));
  if (tail_.size() > kTailLines) tail_.pop_front();
  line_.clear();
}

bool Child::ReadOutput(const LineFn& on_line) {
  char buffer[1 << 14];
  while (true) {
    const ssize_t count = read(output_.get(), buffer, sizeof(buffer));
    if (count < 0 && errno == EINTR) continue;
    if (count < 0 && (errno == EAGAIN || errno == EWOULDBLOCK)) return true;
    if (count <= 0) {
      TakeLine(on_line);
      return false;
    }
    if (log_.get() >= 0) {
      // A full disk must not stop the program; its output is still parsed.
      [[maybe_unused]] const ssize_t written =
          write(log_.get(), buffer, static_cast<size_t>(count));
    }
    for (ssize_t i = 0; i < count; ++i) {
      if (buffer[i] == '\n' || buffer[i] == '\r') {
        TakeLine(on_line);
      } else {
        line_ += buffer[i];
        if (line_.size() >= kMaxLine) TakeLine(on_line);
      }
    }
  }
}

// waitpid, whatever signals arrive.
pid_t WaitFor(pid_t pid, int* status, int options) {
  pid_t result;
  do {
    result = waitpid(pid, status, options);
  } while (result < 0 && errno == EINTR);
  return result;
}

// Kills what is left of the group: it would keep writing into the same folder.
// Among it is the guard, which is waited for only after that.
void Child::EndGroup() {
  if (group_ <= 0) return;
  Signal(SIGKILL);
  WaitFor(group_, nullptr, 0);
  group_ = -1;
}

bool Child::Reap(bool wait) {
  if (pid_ <= 0) return true;
  int status = 0;
  const pid_t ended = WaitFor(pid_, &status, wait ? 0 : WNOHANG);
  if (ended == 0) return false;
  pid_ = -1;
  EndGroup();
  if (ended < 0) return true;  // How it ended is unknown: no success.
  if (WIFEXITED(status)) result_.exit_code = WEXITSTATUS(status);
  if (WIFSIGNALED(status)) result_.signal = WTERMSIG(status);
  return true;
}

ChildResult Child::Finish(const LineFn& on_line) {
  // A stray grandchild may keep the pipe open, so the end of the output may
  // never come, and the last line is taken as it is.
  if (ReadOutput(on_line)) TakeLine(on_line);
  ChildResult result = result_;
  for (const std::string& line : tail_) result.tail += line + "\n";
  return result;
}

void WaitForOutput(const std::vector<std::unique_ptr<Child>>& children) {
  std::vector<pollfd> descriptors;
  for (const auto& child : children) {
    if (child) descriptors.push_back({child->output(), POLLIN, 0});
  }
  poll(descriptors.data(), descriptors.size(), kPollMilliseconds);
}

// Without this the kernel forgets how a program ended as soon as it has, if
// whoever started this process let it ignore SIGCHLD (trap '' CHLD).
void StopIgnoringChildren() {
  struct sigaction action = {};
  if (sigaction(SIGCHLD, nullptr, &action) != 0 ||
      (action.sa_flags & SA_SIGINFO) != 0 || action.sa_handler != SIG_IGN) {
    return;
  }
  action.sa_handler = SIG_DFL;
  sigaction(SIGCHLD, &action, nullptr);
}

// Asks all to end, and makes them.
void Terminate(std::vector<std::unique_ptr<Child>>* children) {
  for (const auto& child : *children) {
    if (child) child->Signal(SIGTERM);
  }
  const auto deadline = std::chrono::steady_clock::now() + kGracePeriod;
  bool running = true;
  while (running && std::chrono::steady_clock::now() < deadline) {
    running = false;
    WaitForOutput(*children);
    for (auto& child : *children) {
      if (!child) continue;
      const bool open = child->ReadOutput({});
      if (child->Reap(false)) {
        child.reset();
      } else {
        running = true;
        // A closed pipe makes poll return at once: do not spin.
        if (!open) usleep(kClosedMicroseconds);
      }
    }
  }
  children->clear();  // Kills what is left.
}

}  // namespace

std::string ChildResult::Describe() const {
  if (timed_out) {
    return "no end within " +
           std::to_string(static_cast<int64_t>(time_limit_s)) + " s";
  }
  if (signal != 0) {
    return "signal " + std::to_string(signal) + " (" + strsignal(signal) + ")";
  }
  if (exit_code < 0) return "an unknown exit code";
  return "exit code " + std::to_string(exit_code);
}

Status RunChildren(const ChildBatch& batch,
                   const CancellationToken* cancellation) {
  StopIgnoringChildren();
  const size_t slots = static_cast<size_t>(std::max(1, batch.max_parallel));
  std::vector<std::unique_ptr<Child>> children(slots);
  std::vector<size_t> job(slots, 0);
  size_t next = 0;
  size_t done = 0;
  Status status;
  while (status.ok() && done < batch.count) {
    if (IsCancelled(cancellation)) {
      status = InterruptedError("stopped on request");
      break;
    }
    for (size_t slot = 0; slot < slots && next < batch.count; ++slot) {
      if (children[slot]) continue;
      StatusOr<ChildCommand> command = batch.prepare(next);
      status = command.status();
      if (!status.ok()) break;
      job[slot] = next++;
      children[slot] = std::make_unique<Child>();
      status = children[slot]->Start(*command);
      if (!status.ok()) break;
    }
    if (!status.ok()) break;

    WaitForOutput(children);
    for (size_t slot = 0; slot < slots && status.ok(); ++slot) {
      if (!children[slot]) continue;
      children[slot]->KillWhenOverdue();
      const LineFn on_line = [&](std::string_view line) {
        if (batch.on_line) batch.on_line(job[slot], line);
      };
      const bool open = children[slot]->ReadOutput(on_line);
      if (!children[slot]->Reap(false)) {
        if (!open) usleep(kClosedMicroseconds);
        continue;
      }
      const ChildResult result = children[slot]->Finish(on_line);
      children[slot].reset();
      ++done;
      if (batch.finished) status = batch.finished(job[slot], result);
    }
  }
  Terminate(&children);
  return status;
}

StatusOr<ChildResult> RunChild(const ChildCommand& command,
                               const LineFn& on_line,
                               const CancellationToken* cancellation) {
  ChildResult outcome;
  ChildBatch batch;
  batch.count = 1;
  batch.prepare = [&](size_t) { return command; };
  batch.finished = [&](size_t, const ChildResult& result) {
    outcome = result;
    return Status();
  };
  batch.on_line = [&](size_t, std::string_view line) {
    if (on_line) on_line(line);
  };
  FREEGS_RETURN_IF_ERROR(RunChildren(batch, cancellation));
  return outcome;
}

}  // namespace freegs::sfm
