// SPDX-License-Identifier: BSD-3-Clause

#include "stages/view/open_file.h"

#include <fcntl.h>
#include <sys/stat.h>
#include <system_error>
#include <unistd.h>

#include "core/io/files.h"

namespace freegs::stages {
namespace {

namespace fs = std::filesystem;

bool LiesBelow(const fs::path& path, const fs::path& root) {
  const fs::path relative = path.lexically_relative(root);
  return !relative.empty() && *relative.begin() != ".." &&
         *relative.begin() != ".";
}

struct NamedType {
  std::string_view extension;
  std::string_view type;
};
constexpr NamedType kContentTypes[] = {
    {".html", "text/html; charset=utf-8"},
    {".js", "text/javascript; charset=utf-8"},
    {".mjs", "text/javascript; charset=utf-8"},
    {".css", "text/css; charset=utf-8"},
    {".json", "application/json"},
    {".map", "application/json"},
    {".wasm", "application/wasm"},
    {".txt", "text/plain; charset=utf-8"},
    {".csv", "text/csv; charset=utf-8"},
    {".svg", "image/svg+xml"},
    {".png", "image/png"},
    {".jpg", "image/jpeg"},
    {".jpeg", "image/jpeg"},
    {".tif", "image/tiff"},
    {".tiff", "image/tiff"},
    {".webp", "image/webp"},
    {".ico", "image/x-icon"},
    {".woff2", "font/woff2"},
    {".glb", "model/gltf-binary"}};

}  // namespace

OpenFile::~OpenFile() { close(descriptor_); }

size_t OpenFile::Read(uint64_t offset, char* bytes, size_t count) const {
  const ssize_t read =
      pread(descriptor_, bytes, count, static_cast<off_t>(offset));
  return read > 0 ? static_cast<size_t>(read) : 0;
}

StatusOr<std::shared_ptr<const OpenFile>> OpenBelow(const fs::path& root,
                                                    std::string_view name) {
  const Status missing =
      BadInputError("there is no file \"" + std::string(name) + "\"");
  if (!IsNameBelowFolder(name) || name.find('\0') != std::string_view::npos) {
    return missing;
  }
  std::error_code error;
  const fs::path base = fs::canonical(root, error);
  if (error) return missing;
  const fs::path path = fs::canonical(base / name, error);
  if (error || !LiesBelow(path, base)) return missing;
  // O_NONBLOCK: to open a pipe must not wait for its writer.
  const int descriptor =
      open(path.c_str(), O_RDONLY | O_CLOEXEC | O_NOFOLLOW | O_NONBLOCK);
  if (descriptor < 0) return missing;
  struct stat facts = {};
  const bool regular = fstat(descriptor, &facts) == 0 && S_ISREG(facts.st_mode);
  const auto file = std::make_shared<const OpenFile>(
      descriptor, regular ? static_cast<uint64_t>(facts.st_size) : 0);
  // A folder of the path may have become a link since the check above.
  const fs::path opened =
      fs::read_symlink("/proc/self/fd/" + std::to_string(descriptor), error);
  if (!regular || error || !LiesBelow(opened, base)) return missing;
  return file;
}

std::string ContentType(std::string_view name) {
  const std::string extension = LowerSuffix(name);
  for (const NamedType& known : kContentTypes) {
    if (extension == known.extension) return std::string(known.type);
  }
  return "application/octet-stream";
}

}  // namespace freegs::stages
