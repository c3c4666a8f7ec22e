// SPDX-License-Identifier: BSD-3-Clause
// Little-endian binary files, written to and read from memory: every file
// format of this project, and those of COLMAP, hold their numbers one after
// another without gaps.
//
//   ByteWriter writer;
//   writer.PutBytes("MAGIC");
//   writer.Put<uint64_t>(values.size());
//   writer.PutArray(values);
//   writer.PutChecksum();
//   const std::string content = std::move(writer).content();
//
//   if (!HasChecksum(content)) return BadInputError("the file is damaged");
//   ByteReader reader(WithoutChecksum(content));
//   uint64_t count = 0;
//   std::vector<float> values;
//   if (!reader.SkipBytes("MAGIC") || !reader.Get(&count) ||
//       !reader.GetArray(count, &values) || !reader.at_end()) {
//     return BadInputError("the file is truncated");
//   }

#ifndef FREEGS_CORE_IO_BYTE_STREAM_H_
#define FREEGS_CORE_IO_BYTE_STREAM_H_

#include <bit>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <string>
#include <string_view>
#include <type_traits>
#include <utility>
#include <vector>

namespace freegs {

// x86-64 and arm64 are little-endian: numbers are copied as they lie in memory.
static_assert(std::endian::native == std::endian::little,
              "numbers are copied to and from little-endian files as they are");

// Appends values to a text of bytes.
class ByteWriter {
 public:
  void Reserve(size_t num_bytes) { content_.reserve(num_bytes); }

  template <typename T>
  void Put(T value) {
    static_assert(std::is_arithmetic_v<T>);
    content_.append(reinterpret_cast<const char*>(&value), sizeof(T));
  }

  // The elements of a vector, array or span of numbers, without their count.
  template <typename Array>
  void PutArray(const Array& array) {
    using T = std::remove_cvref_t<decltype(*array.data())>;
    static_assert(std::is_arithmetic_v<T>);
    PutArray(array.data(), array.size());
  }
  template <typename T>
  void PutArray(const T* values, size_t count) {
    static_assert(std::is_arithmetic_v<T>);
    if (count == 0) return;
    content_.append(reinterpret_cast<const char*>(values), count * sizeof(T));
  }

  void PutBytes(std::string_view bytes) { content_.append(bytes); }

  // A uint64 with the number of bytes, then the bytes.
  void PutText(std::string_view text) {
    Put<uint64_t>(text.size());
    PutBytes(text);
  }

  // The bytes and a zero; the text must not hold a zero itself.
  void PutTerminatedText(std::string_view text) {
    PutBytes(text);
    content_.push_back('\0');
  }

  // A uint64: the 64-bit XXH3 of all bytes so far.
  void PutChecksum();

  const std::string& content() const& { return content_; }
  std::string content() && { return std::move(content_); }

 private:
  std::string content_;
};

// Collects what is to be written without copying the arrays: they are kept as
// views, so they must not change or go before the pieces are written.
class PieceWriter {
 public:
  template <typename T>
  void Put(T value) {
    small_.back().Put(value);
  }
  void PutText(std::string_view text) { small_.back().PutText(text); }
  void PutBytes(std::string_view bytes) { small_.back().PutBytes(bytes); }

  // The elements of a vector of numbers, without their count.
  template <typename T>
  void PutArray(const std::vector<T>& array) {
    static_assert(std::is_arithmetic_v<T>);
    if (array.empty()) return;
    arrays_.emplace_back(reinterpret_cast<const char*>(array.data()),
                         array.size() * sizeof(T));
    small_.emplace_back();
  }

  // All pieces in the order in which they were put. They live as long as this
  // writer.
  std::vector<std::string_view> Pieces() const {
    std::vector<std::string_view> pieces;
    for (size_t k = 0; k < small_.size(); ++k) {
      pieces.push_back(small_[k].content());
      if (k < arrays_.size()) pieces.push_back(arrays_[k]);
    }
    return pieces;
  }

 private:
  // Array k lies between the values in small_[k] and small_[k + 1].
  std::vector<ByteWriter> small_ = std::vector<ByteWriter>(1);
  std::vector<std::string_view> arrays_;
};

// Takes values off the front of `bytes`, which must outlive the reader. Every
// function returns false when the bytes that it needs are not there; it then
// takes nothing, leaves its target alone and allocates nothing, so a file with
// a count of 2^60 fails like any other truncated file.
class ByteReader {
 public:
  explicit ByteReader(std::string_view bytes) : rest_(bytes) {}

  bool at_end() const { return rest_.empty(); }
  size_t remaining() const { return rest_.size(); }

  template <typename T>
  bool Get(T* value) {
    static_assert(std::is_arithmetic_v<T>);
    if (rest_.size() < sizeof(T)) return false;
    std::memcpy(value, rest_.data(), sizeof(T));
    rest_.remove_prefix(sizeof(T));
    return true;
  }

  // `count` numbers into an array that is resized to hold them.
  template <typename T>
  bool GetArray(uint64_t count, std::vector<T>* array) {
    if (count > rest_.size() / sizeof(T)) return false;
    array->resize(count);
    return GetArray(count, array->data());
  }

  // `count` numbers into memory that has room for them.
  template <typename T>
  bool GetArray(uint64_t count, T* values) {
    static_assert(std::is_arithmetic_v<T>);
    if (count > rest_.size() / sizeof(T)) return false;
    if (count > 0) std::memcpy(values, rest_.data(), count * sizeof(T));
    rest_.remove_prefix(count * sizeof(T));
    return true;
  }

  // What ByteWriter::PutText wrote.
  bool GetText(std::string* text) {
    const std::string_view before = rest_;
    uint64_t size = 0;
    if (!Get(&size) || size > rest_.size()) {
      rest_ = before;
      return false;
    }
    text->assign(rest_.substr(0, size));
    rest_.remove_prefix(size);
    return true;
  }

  // What ByteWriter::PutTerminatedText wrote.
  bool GetTerminatedText(std::string* text) {
    const size_t end = rest_.find('\0');
    if (end == std::string_view::npos) return false;
    text->assign(rest_.substr(0, end));
    rest_.remove_prefix(end + 1);
    return true;
  }

  // A uint64 that counts items of at least `min_bytes` each (one or more), all
  // of which can still follow. Room for `count` items may be reserved.
  bool GetCount(size_t min_bytes, uint64_t* count) {
    const std::string_view before = rest_;
    uint64_t value = 0;
    if (!Get(&value) || value > rest_.size() / min_bytes) {
      rest_ = before;
      return false;
    }
    *count = value;
    return true;
  }

  // Exactly these bytes, such as a format's magic number.
  bool SkipBytes(std::string_view expected) {
    if (!rest_.starts_with(expected)) return false;
    rest_.remove_prefix(expected.size());
    return true;
  }

 private:
  std::string_view rest_;
};

inline constexpr size_t kChecksumBytes = 8;

// Whether the last eight bytes are what PutChecksum writes after the others.
bool HasChecksum(std::string_view content);

// `content` (eight bytes or more) without its checksum.
inline std::string_view WithoutChecksum(std::string_view content) {
  return content.substr(0, content.size() - kChecksumBytes);
}

}  // namespace freegs

#endif  // FREEGS_CORE_IO_BYTE_STREAM_H_
