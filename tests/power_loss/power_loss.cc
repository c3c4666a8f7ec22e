// SPDX-License-Identifier: BSD-3-Clause
// Loaded into a program with LD_PRELOAD, keeps a copy of what a loss of power
// would leave of a folder, as of each time that something in it is renamed. The
// environment says where:
//
//   POWER_LOSS_ROOT    the folder that is watched
//   POWER_LOSS_SHADOW  where copies go: SHADOW/cuts/0000/{strict,reordered},
//                      and beside them log.txt of ROOT as it was
//   POWER_LOSS_EVERY   only every so many renames get a copy (default: 1)
//   POWER_LOSS_REFUSED the name of a folder of which the disk does not take
//                      what was written: syncfs fails
//
// `strict` has only what was flushed: a file has the content of its last fsync,
// and a folder the names of its last fsync. `reordered` has all names as they
// are, because a file system may write them earlier than it must, and the
// content of the last fsync. A file that was never flushed is empty.
//
// Files and folders are told apart by inode and time of birth, because a new
// file often gets the inode of a deleted one.

#include <cerrno>
#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <dlfcn.h>
#include <fcntl.h>
#include <filesystem>
#include <fstream>
#include <string>
#include <sys/file.h>
#include <sys/stat.h>
#include <system_error>
#include <unistd.h>

namespace {

namespace fs = std::filesystem;

[[noreturn]] void Fail(const std::string& what) {
  std::fprintf(stderr, "power_loss: %s\n", what.c_str());
  std::abort();
}

std::string Environment(const char* name) {
  const char* value = std::getenv(name);
  return value == nullptr ? "" : value;
}

template <typename Function>
Function* Real(const char* name) {
  return reinterpret_cast<Function*>(dlsym(RTLD_NEXT, name));
}

bool IsBelow(const fs::path& path, const fs::path& root) {
  const fs::path inside =
      fs::absolute(path).lexically_normal().lexically_relative(root);
  return !inside.empty() && *inside.begin() != "..";
}

std::string KeyOf(const fs::path& path) {
  struct statx info = {};
  if (statx(AT_FDCWD,
            path.c_str(),
            AT_SYMLINK_NOFOLLOW,
            STATX_INO | STATX_BTIME,
            &info) != 0) {
    return "";  // Deleted by another thread or process.
  }
  if ((info.stx_mask & STATX_BTIME) == 0) {
    Fail("this file system has no time of birth");
  }
  return std::to_string(info.stx_ino) + "-" +
         std::to_string(info.stx_btime.tv_sec) + "-" +
         std::to_string(info.stx_btime.tv_nsec);
}

// What is on the disk of the watched folder. All processes of a run share it.
class Shadow {
 public:
  // Locks it for this thread as long as the object lives.
  Shadow()
      : root_(Environment("POWER_LOSS_ROOT")),
        shadow_(Environment("POWER_LOSS_SHADOW")) {
    if (root_.empty() || shadow_.empty()) return;
    const int error = errno;
    fs::create_directories(shadow_ / "flushed");
    fs::create_directories(shadow_ / "cuts");
    lock_ =
        open((shadow_ / "lock").c_str(), O_RDWR | O_CREAT | O_CLOEXEC, 0644);
    if (lock_ < 0 || flock(lock_, LOCK_EX) != 0) Fail("cannot lock");
    errno = error;
  }
  Shadow(const Shadow&) = delete;
  Shadow& operator=(const Shadow&) = delete;
  ~Shadow() {
    if (lock_ >= 0) close(lock_);
  }

  bool Watches(const fs::path& path) const {
    return lock_ >= 0 && IsBelow(path, root_);
  }

  // An open file or folder was flushed.
  void Flushed(int descriptor) const {
    std::error_code error;
    const fs::path path =
        fs::read_symlink("/proc/self/fd/" + std::to_string(descriptor), error);
    if (!error && Watches(path)) Keep(path);
  }

  // Everything was flushed.
  void FlushedAll() const {
    if (lock_ >= 0) KeepTree(root_);
  }

  // Copies what a loss of power would leave now.
  void Cut() const {
    std::ofstream(shadow_ / "renames", std::ios::app) << '.';
    const auto renames = fs::file_size(shadow_ / "renames") - 1;
    const std::string every = Environment("POWER_LOSS_EVERY");
    if (renames % (every.empty() ? 1 : std::stoul(every)) != 0) return;
    std::string number = std::to_string(renames);
    number.insert(0, 4 - std::min<size_t>(4, number.size()), '0');
    const fs::path cut = shadow_ / "cuts" / number;
    fs::create_directories(cut);
    RestoreStrict(KeyOf(root_), cut / "strict");
    RestoreReordered(root_, cut / "reordered");
    std::error_code none;
    fs::copy_file(root_ / "log.txt", cut / "log.txt", none);
  }

 private:
  fs::path FlushedPath(const std::string& key) const {
    return shadow_ / "flushed" / key;
  }

  // A regular file is kept as a copy, a folder as one line "TYPE KEY NAME" per
  // entry, a link as its target.
  void Keep(const fs::path& path) const {
    std::error_code error;
    const fs::file_status status = fs::symlink_status(path, error);
    const std::string key = KeyOf(path);
    if (key.empty()) return;
    const fs::path kept = FlushedPath(key);
    if (fs::is_symlink(status)) {
      std::ofstream(kept) << fs::read_symlink(path, error).string();
    } else if (fs::is_directory(status)) {
      std::ofstream listing(kept);
      for (const auto& entry : fs::directory_iterator(path, error)) {
        const std::string entry_key = KeyOf(entry.path());
        if (entry_key.empty()) continue;
        const char type = entry.is_symlink()     ? 'l'
                          : entry.is_directory() ? 'd'
                                                 : 'f';
        listing << type << ' ' << entry_key << ' '
                << entry.path().filename().string() << '\n';
      }
    } else if (fs::is_regular_file(status)) {
      fs::copy_file(path, kept, fs::copy_options::overwrite_existing, error);
    }
  }

  void KeepTree(const fs::path& folder) const {
    Keep(folder);
    std::error_code error;
    for (const auto& entry : fs::recursive_directory_iterator(folder, error)) {
      Keep(entry.path());
    }
  }

  void RestoreFile(const std::string& key, const fs::path& to) const {
    if (fs::exists(FlushedPath(key))) {
      fs::copy_file(FlushedPath(key), to);
    } else {
      std::ofstream empty(to);
    }
  }

  void RestoreLink(const std::string& key, const fs::path& to) const {
    std::ifstream kept(FlushedPath(key));
    std::string target;
    std::getline(kept, target);
    if (!target.empty()) fs::create_symlink(target, to);
  }

  void RestoreStrict(const std::string& key, const fs::path& to) const {
    fs::create_directory(to);
    std::ifstream listing(FlushedPath(key));
    char type = 0;
    std::string entry_key, name;
    while (listing >> type >> entry_key && listing.get() == ' ' &&
           std::getline(listing, name)) {
      if (type == 'd') {
        RestoreStrict(entry_key, to / name);
      } else if (type == 'l') {
        RestoreLink(entry_key, to / name);
      } else {
        RestoreFile(entry_key, to / name);
      }
    }
  }

  void RestoreReordered(const fs::path& from, const fs::path& to) const {
    fs::create_directory(to);
    std::error_code error;
    for (const auto& entry : fs::directory_iterator(from, error)) {
      const fs::path target = to / entry.path().filename();
      const std::string key = KeyOf(entry.path());
      if (key.empty()) continue;
      if (entry.is_symlink()) {
        fs::copy_symlink(entry.path(), target, error);
      } else if (entry.is_directory()) {
        RestoreReordered(entry.path(), target);
      } else {
        RestoreFile(key, target);
      }
    }
  }

  fs::path root_;
  fs::path shadow_;
  int lock_ = -1;
};

// A copy of a file must be of its content at the time of the call, so that the
// lock is held around both.
template <typename Call>
int Flush(int descriptor, Call call) {
  const Shadow shadow;
  const int result = call();
  const int error = errno;
  if (result == 0) shadow.Flushed(descriptor);
  errno = error;
  return result;
}

}  // namespace

extern "C" int fsync(int descriptor) {
  return Flush(descriptor, [&] { return Real<int(int)>("fsync")(descriptor); });
}

extern "C" int fdatasync(int descriptor) {
  return Flush(descriptor,
               [&] { return Real<int(int)>("fdatasync")(descriptor); });
}

extern "C" int syncfs(int descriptor) noexcept {
  std::error_code unknown;
  const fs::path folder =
      fs::read_symlink("/proc/self/fd/" + std::to_string(descriptor), unknown);
  if (!folder.empty() &&
      folder.filename() == Environment("POWER_LOSS_REFUSED")) {
    errno = EIO;
    return -1;
  }
  const Shadow shadow;
  const int result = Real<int(int)>("syncfs")(descriptor);
  const int error = errno;
  if (result == 0) shadow.FlushedAll();
  errno = error;
  return result;
}

extern "C" int rename(const char* from, const char* to) noexcept {
  const Shadow shadow;
  const int error = errno;
  if (shadow.Watches(from) || shadow.Watches(to)) shadow.Cut();
  errno = error;
  return Real<int(const char*, const char*)>("rename")(from, to);
}
