// SPDX-License-Identifier: BSD-3-Clause
// Errors as values. No library of this project aborts, exits or prints: it
// returns a Status, and the caller decides.

#ifndef FREEGS_CORE_STATUS_H_
#define FREEGS_CORE_STATUS_H_

#include <string>
#include <utility>
#include <variant>

namespace freegs {

// What went wrong, by what the caller can do about it. The program turns these
// into its exit codes (see ExitCode in pipeline/exit_code.h).
enum class StatusCode {
  kOk,
  kInvalidArgument,    // Wrong usage: an option or argument out of range.
  kBadInput,           // A file or folder is missing, unreadable or malformed.
  kUnusableResult,     // The method ran but could not reach a usable result.
  kMissingDependency,  // A program or model file that must be installed.
  kInterrupted,        // The caller asked to stop; progress is saved.
  kInternal,           // A broken invariant or a failing system call.
};

// The outcome of a call that returns no value. The message of an error names
// the file or option, says what is wrong with it, and what to do:
//
//   Status Save(const fs::path& path) {
//     FREEGS_ASSIGN_OR_RETURN(const std::string text, Serialize());
//     FREEGS_RETURN_IF_ERROR(CreateFolders(path.parent_path()));
//     return WriteFileAtomic(path, text);
//   }
class [[nodiscard]] Status {
 public:
  Status() = default;
  Status(StatusCode code, std::string message)
      : code_(code), message_(std::move(message)) {}

  bool ok() const { return code_ == StatusCode::kOk; }
  StatusCode code() const { return code_; }
  const std::string& message() const { return message_; }

  // This error with "context: " before its message. An OK status stays as it
  // is.
  Status Annotated(const std::string& context) const {
    return ok() ? *this : Status(code_, context + ": " + message_);
  }

 private:
  StatusCode code_ = StatusCode::kOk;
  std::string message_;
};

// Each of these makes an error with the code that its name says.
inline Status InvalidArgumentError(std::string message) {
  return {StatusCode::kInvalidArgument, std::move(message)};
}
inline Status BadInputError(std::string message) {
  return {StatusCode::kBadInput, std::move(message)};
}
inline Status UnusableResultError(std::string message) {
  return {StatusCode::kUnusableResult, std::move(message)};
}
inline Status MissingDependencyError(std::string message) {
  return {StatusCode::kMissingDependency, std::move(message)};
}
inline Status InterruptedError(std::string message) {
  return {StatusCode::kInterrupted, std::move(message)};
}
inline Status InternalError(std::string message) {
  return {StatusCode::kInternal, std::move(message)};
}

// A value of type T, or the error that prevented it. Call ok() before reading
// the value: reading it from an error throws std::bad_variant_access.
template <typename T>
class [[nodiscard]] StatusOr {
 public:
  StatusOr(T value) : state_(std::move(value)) {}         // NOLINT: implicit
  StatusOr(Status status) : state_(std::move(status)) {}  // NOLINT: implicit

  bool ok() const { return std::holds_alternative<T>(state_); }
  Status status() const { return ok() ? Status() : std::get<Status>(state_); }

  T& value() & { return std::get<T>(state_); }
  const T& value() const& { return std::get<T>(state_); }
  T&& value() && { return std::get<T>(std::move(state_)); }

  T& operator*() & { return value(); }
  const T& operator*() const& { return value(); }
  T&& operator*() && { return std::move(*this).value(); }
  T* operator->() { return &value(); }
  const T* operator->() const { return &value(); }

 private:
  std::variant<Status, T> state_;
};

}  // namespace freegs

// Leaves the enclosing function with the error, if `expression` is one.
#define FREEGS_RETURN_IF_ERROR(expression)           \
  do {                                               \
    ::freegs::Status freegs_status_ = (expression);  \
    if (!freegs_status_.ok()) return freegs_status_; \
  } while (false)

#define FREEGS_CONCAT_INNER_(a, b) a##b
#define FREEGS_CONCAT_(a, b) FREEGS_CONCAT_INNER_(a, b)

// FREEGS_ASSIGN_OR_RETURN(const Image image, ReadImage(path));
#define FREEGS_ASSIGN_OR_RETURN(declaration, expression) \
  FREEGS_ASSIGN_OR_RETURN_IMPL_(                         \
      FREEGS_CONCAT_(freegs_status_or_, __LINE__), declaration, expression)
#define FREEGS_ASSIGN_OR_RETURN_IMPL_(result, declaration, expression) \
  auto result = (expression);                                          \
  if (!result.ok()) return result.status();                            \
  declaration = std::move(result).value()

#endif  // FREEGS_CORE_STATUS_H_
